// Main loop of fire3dv-mujoco: steps the model at the requested pace and publishes it.
#pragma once

#include <cstdio>
#include <string>

#include "adapters/mujoco/options.h"

namespace fire3dv::mujoco {

// Returns after SIGINT, SIGTERM or SIGHUP, with streams closed in order.
Result<void> run(const Options& options);

// Log line of the program on standard error. Safe for untrusted names.
// Replaces control characters, since names in `text` are untrusted.
inline void log_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  std::fprintf(stderr, "fire3dv-mujoco: %s\n", text.c_str());
}

}  // namespace fire3dv::mujoco
