// Rest poses of the frame loop: animations, and nodes and joints that the user moves.
#include <chrono>
#include <utility>

#include "renderer/app/frame_loop.h"
#include "renderer/state/edits/node_transform.h"

namespace fire3dv::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kViewersFrame = std::chrono::milliseconds(16);  // between steps of an animation

}  // namespace

// Nodes and joints that the user moves, when they or the scene change.
void FrameLoop::pose_by_hand() {
  const bool has_robot = robot_ && *robot_;
  Posed wanted{scene_.replaced(), scene_.user_revision(), {}, scene_.user_edits().transforms.empty()};
  if (has_robot) {
    wanted.joints = (*robot_)->positions();
    wanted.is_at_rest &= wanted.joints.empty();
  }
  if (wanted == posed_) return;
  if (has_robot && wanted.scene != posed_.scene) (*robot_)->set_scene(scene_.scene(), poses_.names());
  const bool is_at_rest = wanted.is_at_rest && posed_.is_at_rest;
  posed_ = std::move(wanted);
  if (!animations_ && !is_at_rest) set_rest(state::rest_pose(scene_.scene()));
}

void FrameLoop::set_rest(const state::RestPose& rest) {
  const state::NodeTransforms& transforms = scene_.user_edits().transforms;
  const bool is_by_joints = robot_ && *robot_ && (*robot_)->is_moved();
  if (!is_by_joints && transforms.empty()) return poses_.set_rest(rest);
  state::RestPose posed = rest;
  if (is_by_joints) (*robot_)->apply(posed);
  state::apply_transforms(transforms, scene_.scene(), posed);
  poses_.set_rest(posed);
}

void FrameLoop::animate() {
  if (animation_timeline_) {
    set_rest(animations_->at(animation_timeline_->at(poses_.sim_time_ns())));
    return;
  }
  const double now_s = static_cast<double>(images_) / state::kHeadlessImagesPerSecond;
  set_rest(animations_->at(animation_clock_.at(poses_.sim_time_ns(), now_s)));
}

void FrameLoop::animate_for_viewers() {
  if (!animations_ || !live_view_->has_viewers() || Clock::now() - animated_ < kViewersFrame) return;
  animated_ = Clock::now();
  animate();
}

}  // namespace fire3dv::app
