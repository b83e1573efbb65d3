// Text of a fault that nlohmann::json reports, for users.
#pragma once

#include <string>
#include <string_view>

namespace fire3dv {

// Without the library's tag in front: "[json.exception.parse_error.101] parse error at line 1, ..." begins
// with the JSON path.
inline std::string json_fault(std::string_view what) {
  const size_t end = what.find("] ");
  if (what.starts_with("[json.exception.") && end != std::string_view::npos) what.remove_prefix(end + 2);
  return std::string(what);
}

}  // namespace fire3dv
