// Real-time pacing of simulated time. A simulation that falls behind by more than 250 ms restarts its
// schedule instead of catching up, for example after suspend.
#pragma once

#include <algorithm>
#include <chrono>

namespace fire3dv::mujoco {

class Pace {
 public:
  using Clock = std::chrono::steady_clock;

  // speed: simulated seconds per second of wall time; 0: unlimited.
  explicit Pace(double speed) : speed_(speed) {}
  void restart() { running_ = false; }

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
