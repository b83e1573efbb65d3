// Image size and quality of one viewer of the live view, adapted to the time that its images take.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace fire3dv::app {

// Steps from the best to the smallest images. Slow images go one step down at once; several fast ones in a
// row go one step up, and after each relapse more of them are needed. Sides of half the canvas are the least:
// where the renderer is slow, smaller images look worse and are hardly faster. Only memory makes them
// smaller.
class AdaptiveQuality {
 public:
  struct Step {
    float scale;  // of the canvas' sides
    int quality;  // of JPEG
  };
  static constexpr std::array<Step, 6> kSteps{
      {{1, 85}, {1, 65}, {0.75f, 65}, {0.5f, 65}, {0.5f, 40}, {0.25f, 40}}};
  // An image of full size and quality, for a view that stands.
  static constexpr Step kRefined{1, 92};
  static constexpr double kSlow_s = 0.15, kFast_s = 0.07;

  const Step& step() const { return kSteps[step_]; }
  // Sharp: images of full size, however slow.
  void prefer_sharp(bool is_sharp) {
    least_ = is_sharp ? kLeastSharp : kLeastSmooth;
    step_ = std::min(step_, least_);
    fast_ = 0;
  }
  // An image with step() was requested, and displayed this much later.
  void on_shown(double seconds) {
    if (seconds > kSlow_s) {
      if (step_ < least_) ++step_;
      needed_ = std::min(2 * needed_, kMaxNeeded);
      fast_ = 0;
    } else if (seconds < kFast_s && ++fast_ >= needed_) {
      if (step_ > 0) --step_;
      fast_ = 0;
    }
  }
  // The renderer has no memory for images of this size. Returns false if there is no smaller one.
  bool on_refused() {
    const float refused = step().scale;
    while (step_ + 1 < kSteps.size() && kSteps[step_ + 1].scale == kSteps[step_].scale) ++step_;
    if (step_ + 1 < kSteps.size()) ++step_;
    fast_ = 0;
    return step().scale < refused;
  }

 private:
  static constexpr int kMinNeeded = 5, kMaxNeeded = 80;
  static constexpr size_t kLeastSharp = 1, kLeastSmooth = 4;
  size_t step_ = 0, least_ = kLeastSmooth;
  int fast_ = 0, needed_ = kMinNeeded;
};

}  // namespace fire3dv::app
