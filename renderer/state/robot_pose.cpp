#include "renderer/state/robot_pose.h"

#include <algorithm>
#include <utility>

namespace fire3dv::state {
namespace {

glm::mat4 matrix_of(const robot::Transform& t) {
  glm::mat4 matrix(1);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column)
      matrix[column][row] = static_cast<float>(t.m[static_cast<size_t>(row * 4 + column)]);
  }
  return matrix;
}

}  // namespace

RobotPose::RobotPose(robot::Robot robot) : robot_(std::move(robot)), home_(robot_.positions()) {
  node_of_body_.assign(robot_.bodies().size(), scene::kNone);
}

bool RobotPose::is_scalar(size_t joint) const {
  return robot_.joints()[joint].position_count == 1;
}

JointPositions RobotPose::positions_of(size_t pose) const {
  const std::vector<double>& numbers = robot_.named_poses()[pose].positions;
  JointPositions positions;
  for (size_t joint = 0; joint < robot_.joints().size(); ++joint) {
    const robot::RobotJoint& of = robot_.joints()[joint];
    if (of.position_count == 0) continue;
    const auto first = numbers.begin() + static_cast<std::ptrdiff_t>(of.position_index);
    positions[joint].assign(first, first + static_cast<std::ptrdiff_t>(of.position_count));
  }
  return positions;
}

void RobotPose::set_scene(const scene::Scene& scene, const NodeNames& names) {
  body_of_node_.assign(scene.nodes.size(), SIZE_MAX);
  parents_.clear();
  for (const scene::Node& node : scene.nodes) parents_.push_back(node.parent);
  for (size_t body = 0; body < node_of_body_.size(); ++body) {
    const robot::RobotBody& of = robot_.bodies()[body];
    node_of_body_[body] = of.scale ? names.find(of.node) : scene::kNone;
    if (node_of_body_[body] != scene::kNone) body_of_node_[node_of_body_[body]] = body;
  }
}

uint32_t RobotPose::node_of(size_t joint) const {
  return node_of_body_[robot_.joints()[joint].body];
}

bool RobotPose::set(const JointPositions& positions) {
  if (positions == positions_) return false;
  positions_ = positions;
  (void)robot_.set_positions(home_);
  for (const auto& [joint, numbers] : positions_)
    if (joint < robot_.joints().size()) (void)robot_.set_joint(joint, numbers, {.clamps = true});
  return true;
}

void RobotPose::apply(RestPose& pose) {
  FIRE3DV_ASSERT(pose.world_from_node.size() == parents_.size());
  const std::vector<robot::Transform>& model_from_body = robot_.poses();
  const glm::mat4 world_from_model = matrix_of(robot_.world_from_model());
  std::vector<bool> is_moved(parents_.size());
  for (size_t node = 0; node < parents_.size(); ++node) {
    const uint32_t parent = parents_[node];
    const glm::mat4 world_from_parent = parent == scene::kNone ? glm::mat4(1) : pose.world_from_node[parent];
    if (const size_t body = body_of_node_[node]; body != SIZE_MAX) {
      const robot::Vector& scale = *robot_.bodies()[body].scale;
      const glm::vec3 factors(scale[0], scale[1], scale[2]);
      pose.world_from_node[node] = glm::scale(world_from_model * matrix_of(model_from_body[body]), factors);
      pose.parent_from_node[node] = glm::inverse(world_from_parent) * pose.world_from_node[node];
      is_moved[node] = true;
    } else if (parent != scene::kNone && is_moved[parent]) {
      pose.world_from_node[node] = world_from_parent * pose.parent_from_node[node];
      is_moved[node] = true;
    }
  }
}

}  // namespace fire3dv::state
