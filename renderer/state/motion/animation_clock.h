// Clock of the scene's animations, in seconds.
#pragma once

#include <cstdint>
#include <optional>

namespace fire3dv::state {

// Image rate of animations without a window: independent of the machine, so that a command reproduces its
// images.
constexpr int kHeadlessImagesPerSecond = 30;

// Simulated time of a stream while it is available; before and after, advances with `now_s`.
class AnimationClock {
 public:
  double at(std::optional<int64_t> sim_time_ns, double now_s) {
    if (!sim_time_ns) return since_s_ + (now_s - since_now_s_);
    since_now_s_ = now_s;
    since_s_ = static_cast<double>(*sim_time_ns) * 1e-9;
    return since_s_;
  }

 private:
  double since_s_ = 0, since_now_s_ = 0;
};

}  // namespace fire3dv::state
