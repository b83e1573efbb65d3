// The command line of both programs.
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

// Nothing: leave with *exit_code, which is 0 after --help and 2 after a mistake; the text has been printed.
std::optional<Options> parse_options(int argc, char** argv, const char* program, const char* about,
                                     int* exit_code);

}  // namespace two_simulators
