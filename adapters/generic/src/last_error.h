// Per-thread error of a C call: a return code and a message for fire3dv_last_error. Setting it allocates
// nothing.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <exception>
#include <new>
#include <string_view>

#include "fire3dv/client.h"

namespace fire3dv::client {

inline thread_local char last_error_text[1024] = "";

// Stores the message, truncated to the thread's buffer, and returns the code.
inline int fail(int code, std::string_view sentence) noexcept {
  const size_t length = std::min(sentence.size(), sizeof last_error_text - 1);
  std::memcpy(last_error_text, sentence.data(), length);
  last_error_text[length] = '\0';
  return code;
}

inline const char* last_error() noexcept {
  return last_error_text;
}

// Runs the body of a C function and converts exceptions to codes, since none may reach C callers. Only
// resource failures throw here.
template <typename Body>
int guarded(Body&& body) noexcept {
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return fail(FIRE3DV_ERROR_SYSTEM, "out of memory");
  } catch (const std::exception& thrown) {
    return fail(FIRE3DV_ERROR_SYSTEM, thrown.what());
  }
}

}  // namespace fire3dv::client
