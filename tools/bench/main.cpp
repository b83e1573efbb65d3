// fire3dv-bench: measurements that readers of the README can repeat.
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tools/bench/publish_bench.h"

int main(int argc, char** argv) {
  if (argc >= 2 && std::strcmp(argv[1], "transport") == 0 && argc <= 3) {
    const long rounds = argc == 3 ? std::strtol(argv[2], nullptr, 10) : 301;
    if (rounds >= 1 && rounds <= 1'000'000) return fire3dv::bench::publish_bench(static_cast<int>(rounds));
  }
  std::fprintf(stderr, "usage: fire3dv-bench transport [ROUNDS]   (1 to 1000000; default 301)\n");
  return 2;
}
