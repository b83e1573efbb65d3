// Access control of the live view: the tokens in its links, and the checks of Host and Origin headers that
// keep other web sites out.
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

// Host header that no DNS rebinding can produce: an IP address, localhost, or `own_host` as the user wrote
// it. With TLS the browser has checked the name against the certificate, so any name is accepted.
bool is_host_allowed(std::string_view host_header, std::string_view own_host, bool tls);
// True if the page that opens a WebSocket was loaded from this server.
bool is_origin_allowed(std::string_view origin, std::string_view host_header, bool tls);

}  // namespace fire3dv::serve
