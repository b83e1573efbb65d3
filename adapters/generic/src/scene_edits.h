// Conversion of arguments to scene edits, shared by the entry points of scene.h, markers.h and scalars.h.
#pragma once

#include <cstddef>
#include <cstring>
#include <string>

#include "protocol/wire/scene_edit.h"
#include "stream.h"

namespace fire3dv::client {

// Checks and sends an edit. Returns FIRE3DV_OK or an error code, after fail().
int set_edit(fire3dv_stream* stream, const char* name, wire::Property property, wire::EditValue value);

inline std::string text_of(const char* text, size_t max_bytes) {
  // One byte above the limit suffices for the check to refuse the text.
  return text ? std::string(text, strnlen(text, max_bytes + 1)) : std::string();
}

// Returns null when `given` is readable, else the error message.
template <typename Struct>
const char* struct_error(const Struct* given, const char* null, const char* size) {
  if (!given) return null;
  return struct_is_known(given, given->struct_size, sizeof *given) ? nullptr : size;
}

}  // namespace fire3dv::client
