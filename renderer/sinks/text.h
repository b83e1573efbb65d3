// Sanitisers for untrusted text (adapter and camera names) in output files.
#pragma once

#include <string>
#include <string_view>

namespace fire3dv::sinks {

// Returns valid UTF-8 without control characters, cut to max_bytes between characters. Invalid bytes become
// '?'.
std::string printable_utf8(std::string_view text, size_t max_bytes);

// Returns a quoted JSON string.
std::string json_string(std::string_view text);

// Returns a file name of letters, digits, '-', '_' and '.'. It is never empty, hidden or special; all other
// characters become '_'.
std::string safe_file_name(std::string_view text);

}  // namespace fire3dv::sinks
