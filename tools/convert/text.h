// Sanitising of untrusted text for node names and messages.
#pragma once

#include <string>
#include <string_view>

namespace fire3dv::convert {

// Replaces invalid UTF-8, control characters and bidirectional controls by '?'. Truncates at a character
// boundary.
std::string sanitize_text(std::string_view text, size_t most_bytes = 1024);  // default: limit of stream names

}  // namespace fire3dv::convert
