#include "protocol/import/link_poses.h"

#include <cmath>
#include <span>

namespace fire3dv::imported {

LinkPoses::LinkPoses(robot::Robot& robot, const std::string& prefix) : robot_(robot) {
  for (const robot::RobotBody& body : robot.bodies()) frames_.push_back(prefix + body.node);
  for (size_t i = 0; i < robot.joints().size(); ++i)
    if (robot.joints()[i].position_count == 1) joints_.emplace(robot.joints()[i].name, i);
}

void LinkPoses::set(const std::string& joint, double position) {
  const auto found = joints_.find(joint);
  if (found != joints_.end() && std::isfinite(position))
    (void)robot_.set_joint(found->second, std::span(&position, 1));
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
