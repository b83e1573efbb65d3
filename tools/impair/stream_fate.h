// Where one direction of one connection stalls and where it breaks: at bytes, so that the same streams meet
// the same fate however they are cut into segments.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>

#include "tools/impair/impairment.h"

namespace fire3dv::impair {

class StreamFate {
 public:
  // connection: 0 for a relay's first. to_target: which way.
  StreamFate(const Impairment& impairment, uint64_t connection, bool to_target);

  // Nothing happens within so many further bytes.
  uint64_t quiet_bytes() const;
  // So many have passed, at most quiet_bytes(). True: here the stream stalls.
  bool pass(uint64_t bytes);
  bool is_reset() const { return until_reset_ == 0; }

  // This segment's delay; as many draws as there are segments.
  int64_t delay_ns(const Impairment& impairment);

 private:
  uint64_t draw_bytes(uint64_t mean);

  std::mt19937_64 generator_, jitter_;
  uint64_t stall_after_bytes_;
  uint64_t until_stall_ = UINT64_MAX, until_reset_ = UINT64_MAX;
};

}  // namespace fire3dv::impair
