// Command line of both simulator programs.
#pragma once

#include <cstdint>
#include <optional>

#include "examples/common/link_options.h"

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

}  // namespace two_simulators
