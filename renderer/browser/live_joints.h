// Joints of the scene's robot for pages of the live view: their list, their positions, and moves by hand.
#pragma once

#include <cstdint>
#include <string>

#include "renderer/state/pose_state.h"
#include "renderer/state/robot_pose.h"

namespace fire3dv::app {

constexpr size_t kMaxListedJoints = 256, kMaxListedPostures = 64;

// "joints": names, types and limits of the first kMaxListedJoints revolute and prismatic joints that follow
// no other, and names of the first kMaxListedPostures named poses.
std::string joints_message(const state::RobotPose& robot, uint64_t scene_number);
// "joint_positions": of the listed joints, with the streams that drive them, and the named pose of all
// joints.
std::string joint_positions_message(const state::RobotPose& robot, const state::PoseState& poses,
                                    const state::JointPositions& set, uint64_t scene_number);

// Sets a listed joint within its limits. Returns false for another joint, or one that a stream drives.
bool move_joint(const state::RobotPose& robot, const state::PoseState& poses, size_t listed, double position,
                state::JointPositions& set);

}  // namespace fire3dv::app
