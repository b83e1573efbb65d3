#include "renderer/browser/live_joints.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "base/text.h"
#include "renderer/browser/json_text.h"

namespace fire3dv::app {
namespace {

using Json = nlohmann::json;

constexpr size_t kMaxNameBytes = 100;

std::vector<size_t> listed_joints(const state::RobotPose& robot) {
  std::vector<size_t> listed;
  for (size_t i = 0; i < robot.robot().joints().size() && listed.size() < kMaxListedJoints; ++i)
    if (robot.is_scalar(i)) listed.push_back(i);
  return listed;
}

// Stream that drives the joint's node; null: none.
const state::Stream* driver_of(const state::RobotPose& robot, const state::PoseState& poses, size_t joint) {
  const uint32_t node = robot.node_of(joint);
  const auto& drives = poses.node_drives();
  if (node >= drives.size() || drives[node].stream >= poses.streams().size()) return nullptr;
  return &poses.streams()[drives[node].stream];
}

}  // namespace

std::string joints_message(const state::RobotPose& robot, uint64_t scene_number) {
  Json joints = Json::array(), postures = Json::array();
  for (const size_t i : listed_joints(robot)) {
    const robot::RobotJoint& joint = robot.robot().joints()[i];
    Json limits = joint.has_limits ? Json{joint.lower, joint.upper} : Json();
    joints.push_back({{"name", printable_text(joint.name, kMaxNameBytes)},
                      {"turns", joint.type == robot::JointType::revolute},
                      {"limits", std::move(limits)}});
  }
  for (const robot::NamedPose& pose : robot.robot().named_poses()) {
    if (postures.size() == kMaxListedPostures) break;
    postures.push_back(printable_text(pose.name, kMaxNameBytes));
  }
  return text_of({{"type", "joints"},
                  {"scene", scene_number},
                  {"joints", std::move(joints)},
                  {"postures", std::move(postures)}});
}

std::string joint_positions_message(const state::RobotPose& robot, const state::PoseState& poses,
                                    const state::JointPositions& set, uint64_t scene_number) {
  const std::vector<double>& now = robot.robot().positions();
  Json positions = Json::array(), drivers = Json::array(), posture;
  for (const size_t i : listed_joints(robot)) {
    positions.push_back(now[robot.robot().joints()[i].position_index]);
    const state::Stream* const driver = driver_of(robot, poses, i);
    drivers.push_back(driver ? Json(printable_text(driver->name, kMaxNameBytes)) : Json());
  }
  const std::vector<robot::NamedPose>& named = robot.robot().named_poses();
  const auto is_now = [&](const robot::NamedPose& pose) { return pose.positions == now; };
  const auto known = set.empty() ? named.end() : std::ranges::find_if(named, is_now);
  if (known != named.end()) posture = known - named.begin();
  return text_of({{"type", "joint_positions"},
                  {"scene", scene_number},
                  {"positions", std::move(positions)},
                  {"drivers", std::move(drivers)},
                  {"posture", std::move(posture)},
                  {"moved", !set.empty()}});
}

bool move_joint(const state::RobotPose& robot, const state::PoseState& poses, size_t listed, double position,
                state::JointPositions& set) {
  const std::vector<size_t> joints = listed_joints(robot);
  if (listed >= joints.size() || driver_of(robot, poses, joints[listed])) return false;
  const robot::RobotJoint& joint = robot.robot().joints()[joints[listed]];
  set[joints[listed]] = {joint.has_limits ? std::clamp(position, joint.lower, joint.upper) : position};
  return true;
}

}  // namespace fire3dv::app
