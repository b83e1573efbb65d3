// What a bad network does to what passes through a relay. Seeded: the same datagrams in the same order meet
// the same fate, and streams break at the same bytes.
#pragma once

#include <cstdint>

namespace fire3dv::impair {

struct Impairment {
  double loss = 0;       // datagrams: fraction that vanishes
  double duplicate = 0;  // datagrams: fraction that comes twice
  double reorder = 0;    // datagrams: fraction that overtakes those before it, by coming without delay
  int64_t delay_ns = 0;
  int64_t jitter_ns = 0;           // delay varies by up to this, evenly, either way
  uint64_t bits_per_second = 0;    // 0: no limit. Datagrams that would wait longer than 200 ms for it vanish
  uint64_t stall_after_bytes = 0;  // streams: mean distance of stalls, each way; 0: none
  int64_t stall_ns = 0;            // streams: how long each of them is
  uint64_t reset_after_bytes = 0;  // streams: mean life of a connection, in bytes of either way; 0: no limit
  bool down = false;               // nothing passes: datagrams vanish, streams stand still
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
