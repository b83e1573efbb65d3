// The glTF scene of the simulation as it stands: bodies with the stream's names, floor, lights and cameras.
#pragma once

#include <optional>
#include <string>

#include "examples/bullet_arm/simulation.h"

namespace bullet_arm {

// Empty on success, else one sentence.
std::optional<std::string> write_scene(const Simulation& simulation, const std::string& path);

}  // namespace bullet_arm
