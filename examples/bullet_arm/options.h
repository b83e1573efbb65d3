// The command line.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "examples/common/link_options.h"

namespace bullet_arm {

enum class Pace {
  realtime,  // a step when the clock on the wall says so
  fast,      // as fast as it goes
  lockstep,  // fast, but every n-th frame waits until a renderer has shown it
};

struct Options : examples::LinkOptions {
  double seconds = 8;
  double rate_hz = 240;
  std::optional<uint64_t> frames;  // instead of seconds
  uint64_t seed = 7;
  Pace pace = Pace::realtime;
  uint32_t lockstep_every = 4;
  uint32_t publish_every = 1;
  std::string write_scene;
  bool hash = false;
  bool loop = false;

  // Poses of one run: that of time 0 and one for each step.
  uint64_t frame_count() const;
};

// Nothing: leave with *exit_code, which is 0 after --help and 2 after a mistake; the text has been printed.
std::optional<Options> parse_options(int argc, char** argv, int* exit_code);

}  // namespace bullet_arm
