// Motion of nodes that no stream drives: animations, and nodes and joints that the user moves.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "renderer/app/loop/animation_timeline.h"
#include "renderer/live_scene/live_scene.h"
#include "renderer/state/motion/animation.h"
#include "renderer/state/motion/animation_clock.h"
#include "renderer/state/pose_state.h"
#include "renderer/state/robot_pose.h"

namespace fire3dv::app {

class RestMotion {
 public:
  // Borrows all. animations: null: none play. robot: of the file; empty: nobody moves its joints.
  RestMotion(state::PoseState& poses, LiveScene& scene, std::optional<state::RobotPose>& robot,
             state::AnimationPlayer* animations)
      : poses_(poses), scene_(scene), robot_(robot), animations_(animations) {}

  // Animations follow a timeline that the user controls, instead of the number of drawn images.
  void use_timeline();
  // The timeline of animations; null: there is none.
  AnimationTimeline* timeline() { return timeline_ ? &*timeline_ : nullptr; }
  bool has_animations() const { return animations_ != nullptr; }

  // Applies the user's transforms and joints, when they or the scene have changed.
  void apply_user_poses();
  // Sets the pose of the animations. images: drawn ones.
  void animate(uint64_t images);
  // The same, at the rate of views in browsers at most.
  void animate_for_browsers(uint64_t images);

 private:
  // Scene, user edits and joints of the rest pose.
  struct Posed {
    uint64_t scene = UINT64_MAX, edits = 0;
    state::JointPositions joints;
    bool is_at_rest = true;  // as in the file
    bool operator==(const Posed&) const = default;
  };
  void set_rest(const state::RestPose& rest);

  state::PoseState& poses_;
  LiveScene& scene_;
  std::optional<state::RobotPose>& robot_;
  state::AnimationPlayer* const animations_;
  Posed posed_;
  state::AnimationClock clock_;  // without a timeline
  std::optional<AnimationTimeline> timeline_;
  std::chrono::steady_clock::time_point animated_{};  // for browsers
};

}  // namespace fire3dv::app
