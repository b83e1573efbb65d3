// Scripted publisher: publishes at a fixed rate and records the duration of each call.
#pragma once

#include <cstddef>
#include <string>

namespace fire3dv::bench {

struct PublishOptions {
  std::string uri;
  size_t poses = 100;
  double rate_hz = 1000;
};

// Runs until end of input. For each input line it prints a JSON line about the calls since the last one:
// count, percentiles in nanoseconds, drops, readers. Returns the exit code.
int publish_command(const PublishOptions& options);

}  // namespace fire3dv::bench
