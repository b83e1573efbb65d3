// Rate limiter that selects physics steps to publish. Periods count from due times, so that step size does
// not lower the mean rate. Missed frames are not made up for.
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
