// Steps a simulator and publishes what it does. The simulator's side of the example ends here: what follows
// is the same for Bullet and for MuJoCo.
#pragma once

#include "examples/two_simulators/options.h"
#include "examples/two_simulators/simulator.h"

namespace two_simulators {

// Returns the exit code. Ends in order on SIGINT and SIGTERM.
int run(Simulator& simulator, const char* program, const Options& options);

}  // namespace two_simulators
