// Main loop: steps the simulation at the selected pace and publishes each step.
#pragma once

#include <atomic>

#include "examples/bullet_arm/options.h"
#include "examples/bullet_arm/simulation.h"

namespace bullet_arm {

// Returns the exit code. Closes streams in order once stop is set.
int run_loop(const Options& options, std::unique_ptr<Simulation> simulation, const std::atomic<bool>& stop);

}  // namespace bullet_arm
