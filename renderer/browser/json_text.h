// Text of the JSON messages to browsers.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace fire3dv::app {

// Invalid UTF-8, as names in files may hold, is replaced.
inline std::string text_of(const nlohmann::json& message) {
  return message.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace fire3dv::app
