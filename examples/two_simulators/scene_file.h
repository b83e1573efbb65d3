// glTF export of the bodies of both simulators in rest poses, on one table.
#pragma once

#include <optional>
#include <string>

namespace two_simulators {

// Returns an error message, or nothing on success.
std::optional<std::string> write_scene(const std::string& path);

}  // namespace two_simulators
