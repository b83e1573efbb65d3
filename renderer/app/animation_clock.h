// What time it is for the scene's animations.
#pragma once

#include <cstdint>
#include <optional>

namespace fire3dv::app {

// Without a window animations go by images, so that the same command gives the same images on every machine.
constexpr int kHeadlessImagesPerSecond = 30;

// The simulated time of a stream as long as there is one; before and after it, time goes on by what `now_s`
// advances.
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

}  // namespace fire3dv::app
