#include "renderer/app/loop/rest_motion.h"

#include <utility>

#include "renderer/state/edits/node_transform.h"

namespace fire3dv::app {

void RestMotion::use_timeline() {
  if (animations_) timeline_.emplace(animations_->duration_s());
}

void RestMotion::apply_user_poses() {
  Posed wanted{scene_.replaced(), scene_.user_revision(), {}, scene_.user_edits().transforms.empty()};
  if (robot_) {
    wanted.joints = robot_->positions();
    wanted.is_at_rest &= wanted.joints.empty();
  }
  if (wanted == posed_) return;
  if (robot_ && wanted.scene != posed_.scene) robot_->set_scene(scene_.scene(), poses_.names());
  const bool is_at_rest = wanted.is_at_rest && posed_.is_at_rest;
  posed_ = std::move(wanted);
  if (!animations_ && !is_at_rest) set_rest(state::rest_pose(scene_.scene()));
}

void RestMotion::set_rest(const state::RestPose& rest) {
  const state::NodeTransforms& transforms = scene_.user_edits().transforms;
  const bool is_by_joints = robot_ && robot_->is_moved();
  if (!is_by_joints && transforms.empty()) return poses_.set_rest(rest);
  state::RestPose posed = rest;
  if (is_by_joints) robot_->apply(posed);
  state::apply_transforms(transforms, scene_.scene(), posed);
  poses_.set_rest(posed);
}

void RestMotion::animate(uint64_t images) {
  if (timeline_) {
    set_rest(animations_->at(timeline_->at(poses_.sim_time_ns())));
    return;
  }
  // In whole nanoseconds, as the times of offline runs, which draw the same images.
  const uint64_t now_ns = images * 1'000'000'000 / state::kHeadlessImagesPerSecond;
  const double now_s = static_cast<double>(now_ns) * 1e-9;
  set_rest(animations_->at(clock_.at(poses_.sim_time_ns(), now_s)));
}

void RestMotion::animate_for_browsers(uint64_t images) {
  constexpr auto kPeriod = std::chrono::milliseconds(16);
  const auto now = std::chrono::steady_clock::now();
  if (!animations_ || now - animated_ < kPeriod) return;
  animated_ = now;
  animate(images);
}

}  // namespace fire3dv::app
