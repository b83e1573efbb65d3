// A simulator for scripts that do things to renderers: publishes at a rate and keeps the time of each call.
#pragma once

#include <cstddef>
#include <string>

namespace fire3dv::bench {

struct PublishOptions {
  std::string uri;
  size_t poses = 100;
  double rate_hz = 1000;
};

// Until its input ends. For each line of it, one JSON line of the calls since the last: how many, percentiles
// in nanoseconds, what was dropped, who reads.
int publish_command(const PublishOptions& options);

}  // namespace fire3dv::bench
