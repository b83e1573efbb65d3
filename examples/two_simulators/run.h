// Main loop of both programs: steps a Simulator and publishes its poses.
#pragma once

#include <cstdint>
#include <optional>

#include "examples/common/publisher.h"
#include "examples/two_simulators/simulator.h"

namespace two_simulators {

struct Options : examples::LinkOptions {
  double seconds = 0;  // 0: until interrupted
  uint32_t publish_every = 1;
  bool lockstep = false;
};

// Returns nothing when the program must exit with *exit_code: 0 after --help, 2 after a usage error. The text
// has been printed.
std::optional<Options> parse_options(int argc, char** argv, const char* program, const char* about,
                                     int* exit_code);

// Returns the exit code. Closes streams in order on SIGINT and SIGTERM.
int run(Simulator& simulator, const char* program, const Options& options);

}  // namespace two_simulators
