// Which physics steps are published. Counts from the time that a frame was due, not from when it went out, so
// that the rate does not sink by what is left over of each step; what was missed is not made up for.
#pragma once

#include <cstdint>

namespace fire3dv::ambf {

class RateLimit {
 public:
  explicit RateLimit(double rate_hz = 0)
      : period_ns_(rate_hz > 0 ? static_cast<int64_t>(1e9 / rate_hz) : 0) {}

  bool due(int64_t now_ns) {
    if (period_ns_ == 0) return true;
    if (started_ && now_ns < next_ns_) return false;
    next_ns_ = started_ && now_ns - next_ns_ < period_ns_ ? next_ns_ + period_ns_ : now_ns + period_ns_;
    started_ = true;
    return true;
  }

 private:
  int64_t period_ns_ = 0;  // 0: every step
  int64_t next_ns_ = 0;
  bool started_ = false;
};

}  // namespace fire3dv::ambf
