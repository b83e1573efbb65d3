// Parameters and counters of network impairment. Seeded: equal datagrams in equal order are treated equally,
// and connections break at equal bytes.
#pragma once

#include <cstdint>

namespace fire3dv::impair {

struct Impairment {
  double loss = 0;       // datagrams: probability of loss
  double duplicate = 0;  // datagrams: probability of duplication
  double reorder = 0;    // datagrams: probability of overtaking earlier ones, by omitting the delay
  int64_t delay_ns = 0;
  int64_t jitter_ns = 0;           // uniform variation of the delay, in both directions
  uint64_t bits_per_second = 0;    // 0: unlimited. Datagrams are dropped if they would queue for more than
                                   // 200 ms
  uint64_t stall_after_bytes = 0;  // streams: mean bytes between stalls, per direction; 0: none
  int64_t stall_ns = 0;            // streams: duration of a stall
  uint64_t reset_after_bytes = 0;  // streams: mean bytes until a reset, both directions; 0: none
  bool down = false;               // link down: datagrams are dropped, streams stop
  uint64_t seed = 1;
};

struct RelayCounts {
  uint64_t passed = 0;  // datagrams
  uint64_t lost = 0;
  uint64_t duplicated = 0;
  uint64_t reordered = 0;
  uint64_t connections = 0;  // streams
  uint64_t bytes = 0;
  uint64_t stalls = 0;
  uint64_t resets = 0;
};

}  // namespace fire3dv::impair
