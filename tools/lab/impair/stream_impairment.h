// Impairment model of one stream direction: stalls and resets at byte positions, independent of segmentation.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>

#include "tools/lab/impair/impairment.h"

namespace fire3dv::impair {

class StreamImpairment {
 public:
  // connection: index among the relay's connections, from 0. to_target: direction.
  StreamImpairment(const Impairment& impairment, uint64_t connection, bool to_target);

  // Returns the number of bytes until the next event.
  uint64_t quiet_bytes() const;
  // Records passed bytes, at most quiet_bytes(). Returns true when the stream stalls here.
  bool pass(uint64_t bytes);
  bool is_reset() const { return until_reset_ == 0; }

  // Draws the delay of one segment; call it once per segment.
  int64_t delay_ns(const Impairment& impairment);

 private:
  uint64_t draw_bytes(uint64_t mean);

  std::mt19937_64 generator_, jitter_;
  uint64_t stall_after_bytes_;
  uint64_t until_stall_ = UINT64_MAX, until_reset_ = UINT64_MAX;
};

}  // namespace fire3dv::impair
