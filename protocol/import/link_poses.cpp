#include "protocol/import/link_poses.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace fire3dv::imported {

LinkPoses::LinkPoses(robot::Robot& robot, const std::string& prefix, bool is_in_degrees)
    : robot_(robot), radians_from_unit_(is_in_degrees ? std::numbers::pi / 180 : 1) {
  for (const robot::RobotBody& body : robot.bodies()) frames_.push_back(prefix + body.node);
  for (size_t i = 0; i < robot.joints().size(); ++i)
    if (robot.joints()[i].position_count == 1) joints_.emplace(robot.joints()[i].name, i);
}

void LinkPoses::set(const std::string& joint, double position) {
  const auto found = joints_.find(joint);
  if (found == joints_.end() || !std::isfinite(position)) return;
  if (robot_.joints()[found->second].type == robot::JointType::revolute) {
    double& largest = largest_[found->second];
    largest = std::max(largest, std::abs(position));
    position *= radians_from_unit_;
  }
  (void)robot_.set_joint(found->second, std::span(&position, 1));
}

std::optional<double> LinkPoses::largest_beyond_turn() const {
  size_t beyond = 0;
  double largest = 0;
  for (const auto& [joint, position] : largest_) {
    beyond += position > 2 * std::numbers::pi;
    largest = std::max(largest, position);
  }
  return largest_.size() >= 2 && 2 * beyond > largest_.size() ? std::optional(largest) : std::nullopt;
}

frames::Transform LinkPoses::pose(size_t body) {
  return frames::transform_of(robot_.poses()[body].m);
}

std::vector<TransformSample> LinkPoses::transforms(int64_t time_ns) {
  const frames::Transform root_from_model = inverse(model_from_root());
  std::vector<TransformSample> samples;
  for (size_t i = 1; i < frames_.size(); ++i)
    samples.push_back({frames_[0], frames_[i], time_ns, root_from_model * pose(i)});
  return samples;
}

}  // namespace fire3dv::imported
