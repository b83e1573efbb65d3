// Frame selection by simulated time, and real-time pacing.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>

namespace fire3dv::mujoco {

// Selects frames at a rate of simulated time and detects discontinuities. Due times count from the first
// frame, so that step size does not lower the mean rate.
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

// Real-time pacing. A simulation that falls behind by more than 250 ms restarts its schedule instead of
// catching up, for example after suspend.
class Pace {
 public:
  using Clock = std::chrono::steady_clock;

  // speed: simulated seconds per second of wall time; 0: unlimited.
  explicit Pace(double speed) : speed_(speed) {}
  void restart() { running_ = false; }
  void set_speed(double speed) {
    speed_ = speed;
    restart();
  }

  // Returns the time to sleep before the next call, at most 250 ms, so that stop requests are seen. Zero:
  // sim_time_s is due.
  Clock::duration sleep_before(double sim_time_s, Clock::time_point now) {
    constexpr auto kLongest = std::chrono::milliseconds(250);
    if (speed_ <= 0) return {};
    if (!running_) {
      running_ = true;
      start_ = now;
      start_s_ = sim_time_s;
    }
    const double due_s = (sim_time_s - start_s_) / speed_;
    const double left_s = due_s - std::chrono::duration<double>(now - start_).count();
    if (left_s < -std::chrono::duration<double>(kLongest).count()) restart();
    if (left_s >= std::chrono::duration<double>(kLongest).count()) return kLongest;
    const auto left = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(left_s));
    return std::max(left, Clock::duration::zero());
  }

 private:
  double speed_, start_s_ = 0;
  Clock::time_point start_;
  bool running_ = false;
};

}  // namespace fire3dv::mujoco
