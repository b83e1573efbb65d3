#include "adapters/ros2/robot/robot_links.h"

#include <algorithm>
#include <cmath>

namespace fire3dv::ros2 {

Result<RobotLinks> RobotLinks::read(std::span<const uint8_t> glb) {
  RobotLinks links;
  links.robot_.reset(fire3dv_read_robot(glb.data(), glb.size(), 0));
  if (!links.robot_) return Error{fire3dv_last_error()};
  fire3dv_description description{};
  description.struct_size = sizeof description;
  if (fire3dv_get_robot_description(links.robot_.get(), &description) != FIRE3DV_OK)
    return Error{fire3dv_last_error()};
  for (size_t i = 0; i < description.node_count; ++i) {
    links.names_.emplace_back(description.node_names[i]);
    if (description.body_from_node_count == 0) continue;
    const float* offset = description.body_from_node + (description.body_from_node_count == 1 ? 0 : 12 * i);
    std::array<float, 12>& copy = links.offsets_[links.names_.back()];
    std::copy(offset, offset + 12, copy.begin());
  }
  if (links.names_.empty()) return Error{"the robot has no links"};
  for (size_t i = 0; i < fire3dv_joint_count(links.robot_.get()); ++i) {
    fire3dv_joint joint{};
    joint.struct_size = sizeof joint;
    if (fire3dv_get_joint(links.robot_.get(), i, &joint) != FIRE3DV_OK) continue;
    links.joint_types_.emplace(joint.name, joint.type);
    if (joint.position_count == 1) links.joints_.emplace(joint.name, i);
  }
  return links;
}

const std::array<float, 12>* RobotLinks::body_from_node(const std::string& link) const {
  const auto found = offsets_.find(link);
  return found == offsets_.end() ? nullptr : &found->second;
}

bool RobotLinks::set_joint(const std::string& joint, double position) {
  const auto found = joints_.find(joint);
  return found != joints_.end() && std::isfinite(position) &&
         fire3dv_set_joint(robot_.get(), found->second, &position, 1, 0) == FIRE3DV_OK;
}

Result<std::vector<Transform>> RobotLinks::root_from_links() {
  std::vector<Transform> transforms;
  Transform root_from_model;
  for (size_t i = 0; i < names_.size(); ++i) {
    std::array<double, 12> model_from_link{};
    if (fire3dv_get_node_pose(robot_.get(), names_[i].c_str(), model_from_link.data()) != FIRE3DV_OK)
      return Error{fire3dv_last_error()};
    const Transform pose = transform_of(model_from_link);
    if (i == 0)
      root_from_model = inverse(pose);
    else
      transforms.push_back(root_from_model * pose);
  }
  return transforms;
}

}  // namespace fire3dv::ros2
