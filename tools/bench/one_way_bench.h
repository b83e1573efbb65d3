// What a publish costs and when its frame is there, over each way, beside the barest means of the same kind.
#pragma once

#include "tools/bench/one_way.h"

namespace fire3dv::bench {

struct OneWayOptions {
  int rounds = 31;
  int frames = 100;  // in a row, of one way, before the next has its turn
  double rate_hz = 1000;
  LinkSecurity security;  // ways for which there is no file are left out
};

// Prints Markdown tables. 0, or an exit code when something could not be opened.
int one_way_bench(const OneWayOptions& options);

}  // namespace fire3dv::bench
