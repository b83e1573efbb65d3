#include "renderer/editing/view_state.h"

namespace fire3dv::app {

glm::vec3 position_world(const SurfacePoint& point, const state::PoseState& poses) {
  if (point.node >= poses.node_drives().size()) return point.position_node;
  return poses.world_from_node(point.node) * glm::vec4(point.position_node, 1);
}

const std::string* direct_driver_of(const state::PoseState& poses, uint32_t node) {
  const auto& drives = poses.node_drives();
  if (node >= drives.size() || drives[node].stream >= poses.streams().size()) return nullptr;
  const state::Stream& stream = poses.streams()[drives[node].stream];
  const uint32_t pose = drives[node].pose_index;
  const bool itself = pose < stream.scene_node_of_pose.size() && stream.scene_node_of_pose[pose] == node;
  return itself ? &stream.name : nullptr;
}

}  // namespace fire3dv::app
