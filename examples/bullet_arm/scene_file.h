// glTF export of the simulation's current state: bodies named as in the stream, floor, lights and cameras.
#pragma once

#include <optional>
#include <string>

#include "examples/bullet_arm/simulation.h"

namespace bullet_arm {

// Returns an error message, or nothing on success.
std::optional<std::string> write_scene(const Simulation& simulation, const std::string& path);

}  // namespace bullet_arm
