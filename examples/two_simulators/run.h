// Main loop of both programs: steps a Simulator and publishes its poses.
#pragma once

#include "examples/two_simulators/options.h"
#include "examples/two_simulators/simulator.h"

namespace two_simulators {

// Returns the exit code. Closes streams in order on SIGINT and SIGTERM.
int run(Simulator& simulator, const char* program, const Options& options);

}  // namespace two_simulators
