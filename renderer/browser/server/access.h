// Access control of the live view: the tokens in its links. What keeps other web sites out is in
// protocol/transport/http/access_rules.h.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "base/error.h"

namespace fire3dv::serve {

// Rights of a viewer. view: cameras and images; control: also what all viewers share (visibility, playback).
enum class Access : uint8_t { none, view, control };

// Random secrets of the two links, 32 hexadecimal digits each.
struct Tokens {
  std::string control, view;
};
Tokens random_tokens();
// Tokens that outlive this process: reads the file, or creates it, readable by its owner only.
Result<Tokens> read_or_create_tokens(const std::filesystem::path& file);
// Rights that the token gives, compared in constant time.
Access access_of(const Tokens& tokens, std::string_view token);

}  // namespace fire3dv::serve
