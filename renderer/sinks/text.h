// Text from outside (adapter and camera names) made fit for files that other programs read.
#pragma once

#include <string>
#include <string_view>

namespace fire3dv::sinks {

// Valid UTF-8 without control characters, at most max_bytes, cut between characters. What is not valid
// becomes '?'.
std::string printable_utf8(std::string_view text, size_t max_bytes);

// A quoted JSON string.
std::string json_string(std::string_view text);

// A file name of letters, digits, '-', '_' and '.', never empty, hidden or special; other characters become
// '_'.
std::string safe_file_name(std::string_view text);

}  // namespace fire3dv::sinks
