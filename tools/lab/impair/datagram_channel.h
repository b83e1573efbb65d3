// Impairment model of one datagram direction, without sockets or clock. The relay drives it in real time,
// tests and benchmarks in simulated time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>

#include "tools/lab/impair/impairment.h"

namespace fire3dv::impair {

class DatagramChannel {
 public:
  explicit DatagramChannel(uint64_t seed = 1) : generator_(seed) {}

  struct Fate {
    int copies = 0;  // 0: dropped
    bool overtakes = false;
    int64_t due_ns = 0;
  };
  // Draws the fate of a datagram that arrives now; now_ns must not decrease.
  Fate draw(const Impairment& impairment, size_t bytes, int64_t now_ns);

 private:
  double chance() { return std::uniform_real_distribution<double>(0, 1)(generator_); }

  std::mt19937_64 generator_;
  int64_t free_at_ns_ = 0;  // when the rate-limited link has sent its queue
};

}  // namespace fire3dv::impair
