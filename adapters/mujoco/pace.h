// Simulated time beside the clock on the wall. Who is late is not hurried for long: a machine that was
// suspended does not make up for it.
#pragma once

#include <algorithm>
#include <chrono>

namespace fire3dv::mujoco {

class Pace {
 public:
  using Clock = std::chrono::steady_clock;

  // speed: simulated seconds in one of the wall's; 0: as fast as can be.
  explicit Pace(double speed) : speed_(speed) {}
  void restart() { running_ = false; }

  // How long to sleep before asking again; zero: this moment of the simulation is due. Never long, so that
  // whoever is to stop stops soon.
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
