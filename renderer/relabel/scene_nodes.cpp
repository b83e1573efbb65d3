#include "renderer/relabel/scene_nodes.h"

#include <cmath>

#include "protocol/record/foxglove.h"
#include "protocol/robot/rigid.h"

namespace fire3dv::relabel {
namespace {

constexpr float kRounding = 1e-5f;  // of scale 1 in a file of float matrices

wire::Affine3x4 without_rounding(const wire::Affine3x4& body_from_node) {
  const wire::Affine3x4 identity;
  for (size_t i = 0; i < identity.m.size(); ++i)
    if (std::abs(body_from_node.m[i] - identity.m[i]) > kRounding) return body_from_node;
  return identity;
}

}  // namespace

std::optional<imported::SceneNode> find_node(const scene::Scene& scene, const state::NodeNames& names,
                                             std::string_view name) {
  const uint32_t index = names.find(name);
  if (index == scene::kNone) return std::nullopt;
  const scene::Node& node = scene.nodes[index];
  imported::SceneNode found;
  found.index = index;
  found.name = names.find(node.name) == index ? node.name : node.path;
  wire::Affine3x4d world_from_node;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      world_from_node.m[static_cast<size_t>(row * 4 + column)] = double{node.world_from_node[column][row]};
  const record::RigidPart rigid = record::rigid_part(world_from_node);
  const robot::Transform turn = robot::rotation(rigid.rotation_xyzw);
  found.world_from_body = (robot::translation(rigid.translation) * turn).m;
  for (size_t row = 0; row < 3; ++row)
    for (size_t column = 0; column < 3; ++column) {
      double sum = 0;  // of the inverse rotation with the node's matrix
      for (size_t k = 0; k < 3; ++k) sum += turn.m[k * 4 + row] * world_from_node.m[k * 4 + column];
      found.body_from_node.m[row * 4 + column] = static_cast<float>(sum);
    }
  found.body_from_node = without_rounding(found.body_from_node);
  return found;
}

std::vector<std::string> resting_nodes(const scene::Scene& scene,
                                       const std::vector<imported::SceneNode>& moving) {
  std::vector<bool> moves(scene.nodes.size(), false);
  for (const imported::SceneNode& node : moving) moves[node.index] = true;
  std::vector<std::string> resting;
  for (size_t i = 0; i < scene.nodes.size(); ++i) {  // parents precede their children
    const scene::Node& node = scene.nodes[i];
    if (node.parent != scene::kNone && moves[node.parent]) moves[i] = true;
    if (!moves[i] && node.mesh != scene::kNone) resting.push_back(node.path);
  }
  return resting;
}

}  // namespace fire3dv::relabel
