// The glTF scene of both simulators' bodies at rest, on one table.
#pragma once

#include <optional>
#include <string>

namespace two_simulators {

// Empty on success, else one sentence.
std::optional<std::string> write_scene(const std::string& path);

}  // namespace two_simulators
