// Frame selection by simulated time, with discontinuity detection. Due times count from the first frame, so
// that step size does not lower the mean rate.
#pragma once

#include <cmath>
#include <cstdint>

namespace fire3dv::mujoco {

class FrameClock {
 public:
  explicit FrameClock(double rate_hz) : period_ns_(rate_hz > 0 ? 1e9 / rate_hz : 0) {}

  // Time that runs backwards is a reset; its frame is due immediately.
  bool due(int64_t sim_time_ns) const {
    if (!started_ || sim_time_ns < last_ns_) return true;
    return sim_time_ns != last_ns_ && sim_time_ns >= due_ns(frames_);
  }

  // Records a published frame. Returns true when the frame is a discontinuity.
  bool published(int64_t sim_time_ns) {
    const bool jumped = !started_ || sim_time_ns < last_ns_;
    // Missed frames are not made up for.
    if (jumped || sim_time_ns >= due_ns(frames_ + 1)) {
      start_ns_ = sim_time_ns;
      frames_ = 0;
    }
    ++frames_;
    last_ns_ = sim_time_ns;
    started_ = true;
    return jumped;
  }

  void restart() { started_ = false; }

 private:
  // Simulated time is a sum of steps, so rounding may leave it slightly below a whole period.
  int64_t due_ns(int64_t frame) const {
    constexpr int64_t kSlack_ns = 1000;
    return start_ns_ + std::llround(static_cast<double>(frame) * period_ns_) - kSlack_ns;
  }

  double period_ns_;  // 0: every step
  int64_t start_ns_ = 0, last_ns_ = 0, frames_ = 0;
  bool started_ = false;
};

}  // namespace fire3dv::mujoco
