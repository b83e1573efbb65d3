#include "renderer/app/loop/idle_detection.h"

namespace fire3dv::app {

void IdleDetection::update(const std::array<uint64_t, 3>& revisions, bool is_active) {
  // Motion vectors and two-pass culling refer to the previous image.
  constexpr int kImagesOfChange = 3;
  constexpr auto kLingerTime = std::chrono::milliseconds(700);
  if (revisions == revisions_ && !is_active) return;
  revisions_ = revisions;
  due_images_ = kImagesOfChange;
  changed_ = Clock::now();
  lingers_until_ = changed_ + kLingerTime;
}

bool IdleDetection::take_due_image() {
  if (due_images_ == 0) return false;
  --due_images_;
  return true;
}

}  // namespace fire3dv::app
