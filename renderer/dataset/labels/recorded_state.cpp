#include "renderer/dataset/labels/recorded_state.h"

#include <algorithm>
#include <memory>
#include <set>
#include <variant>

#include "protocol/record/foxglove.h"
#include "protocol/record/mcap/file.h"
#include "protocol/record/playback.h"
#include "protocol/robot/rigid.h"
#include "protocol/wire/decode.h"
#include "renderer/state/node_index.h"

namespace fire3dv::dataset {
namespace {

// Rotation and place of a node; its scale is left out.
robot::Transform rigid_pose(const state::PoseState& poses, uint32_t node) {
  const glm::mat4 matrix = poses.world_from_node(node);
  wire::Affine3x4d world_from_node;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column)
      world_from_node.m[static_cast<size_t>(row * 4 + column)] = double{matrix[column][row]};
  }
  const record::RigidPart rigid = record::rigid_part(world_from_node);
  return robot::translation(rigid.translation) * robot::rotation(rigid.rotation_xyzw);
}

void append_pose(const robot::Transform& pose, std::vector<double>& values) {
  const robot::Quaternion q = robot::quaternion_of(pose);
  values.insert(values.end(), {pose.m[3], pose.m[7], pose.m[11], q[0], q[1], q[2], q[3]});
}

}  // namespace

Result<std::vector<uint32_t>> find_moved_nodes(const std::string& recording, const scene::Scene& scene) {
  auto source = record::open_source(recording);
  if (!source) return source.error();
  auto playback = record::Playback::open(std::move(*source));
  if (!playback) return playback.error();
  const state::NodeNames names(scene);
  wire::Decoder decoder;
  std::set<uint32_t> moved;
  std::vector<bool> is_described(playback->streams().size());
  record::Played played;
  for (auto step = playback->next(played); step != record::Playback::Step::end;
       step = playback->next(played)) {
    if (step != record::Playback::Step::played || played.kind != record::Played::Kind::description) continue;
    const auto decoded = decoder.decode(played.message);
    const auto* const description = decoded ? std::get_if<wire::StreamDescription>(&*decoded) : nullptr;
    if (!description) continue;
    for (const std::string& name : description->node_names) {
      if (const uint32_t node = names.find(name); node != scene::kNone) moved.insert(node);
    }
    is_described[played.stream] = true;
    if (std::find(is_described.begin(), is_described.end(), false) == is_described.end()) break;
  }
  return std::vector<uint32_t>(moved.begin(), moved.end());
}

RecordedState::RecordedState(const scene::Scene& scene, const std::optional<robot::Robot>& robot,
                             const std::vector<uint32_t>& moved_nodes)
    : posed_(moved_nodes) {
  std::set<uint32_t> bodies;
  if (robot) {
    const state::NodeNames nodes(scene);
    for (const robot::RobotBody& body : robot->bodies()) node_of_body_.push_back(nodes.find(body.node));
    bodies.insert(node_of_body_.begin(), node_of_body_.end());
    const bool is_moved = std::any_of(moved_nodes.begin(), moved_nodes.end(),
                                      [&](uint32_t node) { return bodies.contains(node); });
    auto joints = robot::JointReader::make(*robot);
    if (is_moved && !joints) note_ = joints.error().message;
    if (is_moved && joints && !joints->names().empty()) joints_ = std::move(*joints);
  }
  if (joints_) {
    model_from_world_ = robot::inverse(robot->world_from_model());
    names_ = joints_->names();
    std::erase_if(posed_, [&](uint32_t node) { return bodies.contains(node); });
  }
  for (const uint32_t node : posed_) {
    const std::string& name =
        scene.nodes[node].name.empty() ? scene.nodes[node].path : scene.nodes[node].name;
    for (const char* ending : {".x", ".y", ".z", ".qx", ".qy", ".qz", ".qw"})
      (joints_ ? environment_names_ : names_).push_back(name + ending);
  }
}

RecordedState::Values RecordedState::read(const state::PoseState& poses) const {
  Values values;
  if (joints_) {
    std::vector<robot::Transform> model_from_body;
    for (size_t body = 0; body < node_of_body_.size(); ++body)
      model_from_body.push_back(node_of_body_[body] == scene::kNone
                                    ? joints_->rest_pose(body, model_from_body)
                                    : model_from_world_ * rigid_pose(poses, node_of_body_[body]));
    joints_->read(model_from_body, values.state);
  }
  for (const uint32_t node : posed_)
    append_pose(rigid_pose(poses, node), joints_ ? values.environment : values.state);
  return values;
}

}  // namespace fire3dv::dataset
