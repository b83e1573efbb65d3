// One-way latency benchmark: cost of a publish and arrival time of its frame for each link, against the
// simplest transport of the same kind.
#pragma once

#include "tools/lab/bench/links/one_way.h"

namespace fire3dv::bench {

struct OneWayOptions {
  int rounds = 31;
  int frames = 100;  // consecutive frames per transport and turn
  double rate_hz = 1000;
  LinkSecurity security;  // links without key files are skipped
};

// Prints Markdown tables. Returns 0, or an exit code when a link could not be opened.
int one_way_bench(const OneWayOptions& options);

}  // namespace fire3dv::bench
