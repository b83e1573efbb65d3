#include "renderer/dataset/randomize/settle_shapes.h"

#include "renderer/dataset/randomize/axes.h"
#include "renderer/scene/clusters/clusters.h"

namespace fire3dv::dataset {
namespace {

bool collides(const scene::Primitive& primitive) {
  return primitive.topology == scene::Topology::triangles && primitive.index_count > 0;
}

}  // namespace

void SettleShapes::begin_frame(const std::set<uint32_t>& falling, const std::set<uint32_t>& hidden) {
  hidden_ = hidden;
  body_of_.assign(scene_.nodes.size(), scene::kNone);
  for (uint32_t n = 0; n < body_of_.size(); ++n) {
    const uint32_t parent = scene_.nodes[n].parent;
    if (parent != scene::kNone) body_of_[n] = body_of_[parent];
    if (body_of_[n] == scene::kNone && falling.contains(n)) body_of_[n] = n;
  }
}

bool SettleShapes::is_hidden(uint32_t node) const {
  for (uint32_t at = node; at != scene::kNone; at = scene_.nodes[at].parent) {
    if (hidden_.contains(at)) return true;
  }
  return false;
}

FixedTriangles SettleShapes::fixed_triangles(const state::PoseState& poses) const {
  FixedTriangles fixed;
  for (uint32_t n = 0; n < scene_.nodes.size(); ++n) {
    const scene::Node& node = scene_.nodes[n];
    if (node.mesh == scene::kNone || body_of_[n] != scene::kNone || scene::is_deformed(node) || is_hidden(n))
      continue;
    const glm::mat4 world_from_node = poses.world_from_node(n);
    const scene::Mesh& mesh = scene_.meshes[node.mesh];
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
      const scene::Primitive& primitive = scene_.primitives[p];
      if (!collides(primitive)) continue;
      const auto first = static_cast<uint32_t>(fixed.positions_m.size());
      for (uint32_t v = 0; v < primitive.vertex_count; ++v)
        fixed.positions_m.emplace_back(world_from_node *
                                       glm::vec4(scene_.positions[primitive.first_vertex + v], 1));
      for (uint32_t i = 0; i < primitive.index_count; ++i)
        fixed.indices.push_back(first + scene_.indices[primitive.first_index + i]);
    }
  }
  return fixed;
}

const Hull& SettleShapes::hull_of_mesh(uint32_t mesh_index) {
  const auto [cached, is_new] = hulls_.try_emplace(mesh_index);
  if (!is_new) return cached->second;
  std::vector<glm::vec3> points;
  const scene::Mesh& mesh = scene_.meshes[mesh_index];
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    const scene::Primitive& primitive = scene_.primitives[p];
    if (!collides(primitive)) continue;
    const auto first = scene_.positions.begin() + primitive.first_vertex;
    points.insert(points.end(), first, first + primitive.vertex_count);
  }
  cached->second = hull_of(points);
  return cached->second;
}

FallingBody SettleShapes::falling_body(const state::PoseState& poses, uint32_t body) {
  const glm::dmat4 world_from_body(poses.world_from_node(body));
  FallingBody falling;
  falling.rotation = axes_of(world_from_body).rotation;
  falling.position_m = glm::dvec3(world_from_body[3]);
  glm::dmat4 rigid = glm::mat4_cast(falling.rotation);
  rigid[3] = world_from_body[3];
  const glm::dmat4 rigid_from_world = glm::inverse(rigid);
  for (uint32_t n = body; n < scene_.nodes.size(); ++n) {
    const scene::Node& node = scene_.nodes[n];
    if (body_of_[n] != body || node.mesh == scene::kNone || is_hidden(n)) continue;
    const Hull& of_mesh = hull_of_mesh(node.mesh);
    if (of_mesh.empty()) continue;
    const glm::dmat4 body_from_node = rigid_from_world * glm::dmat4(poses.world_from_node(n));
    Hull& hull = falling.hulls.emplace_back();
    for (const glm::vec3& point : of_mesh)
      hull.emplace_back(body_from_node * glm::dvec4(glm::dvec3(point), 1));
  }
  return falling;
}

}  // namespace fire3dv::dataset
