// Command line of the bullet_arm example.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "examples/common/publisher.h"

namespace bullet_arm {

enum class Pace {
  realtime,  // steps follow the wall clock
  fast,      // no delay between steps
  lockstep,  // no delay, but every n-th frame waits until a renderer has shown it
};

struct Options : examples::LinkOptions {
  double seconds = 8;
  double rate_hz = 240;
  std::optional<uint64_t> frames;  // replaces seconds
  uint64_t seed = 7;
  Pace pace = Pace::realtime;
  uint32_t lockstep_every = 4;
  uint32_t publish_every = 1;
  std::string write_scene;
  bool hash = false;
  bool loop = false;

  // Number of published poses per run: the initial one and one per step.
  uint64_t frame_count() const;
};

// Returns nothing when the program must exit with *exit_code: 0 after --help, 2 after a usage error. The text
// has been printed.
std::optional<Options> parse_options(int argc, char** argv, int* exit_code);

}  // namespace bullet_arm
