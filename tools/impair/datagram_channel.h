// One direction of a bad network for datagrams, without sockets and without a clock of its own: what becomes
// of each. The relay asks it in real time, tests and benchmarks in time that they make up.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>

#include "tools/impair/impairment.h"

namespace fire3dv::impair {

class DatagramChannel {
 public:
  explicit DatagramChannel(uint64_t seed = 1) : generator_(seed) {}

  struct Fate {
    int copies = 0;  // 0: it vanishes
    bool overtakes = false;
    int64_t due_ns = 0;
  };
  // Of a datagram that comes now; now_ns never goes back.
  Fate draw(const Impairment& impairment, size_t bytes, int64_t now_ns);

 private:
  double chance() { return std::uniform_real_distribution<double>(0, 1)(generator_); }

  std::mt19937_64 generator_;
  int64_t free_at_ns_ = 0;  // when the limited link has sent what it has
};

}  // namespace fire3dv::impair
