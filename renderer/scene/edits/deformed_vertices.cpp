#include "renderer/scene/edits/deformed_vertices.h"

#include <algorithm>
#include <string>

namespace fire3dv::scene {
namespace {

void copy_primitive(ClusteredGeometry& geometry, uint32_t index) {
  ClusteredPrimitive copy = geometry.primitives[index];
  const uint32_t source_vertex = copy.first_vertex, source_cluster = copy.first_cluster;
  copy.first_vertex = static_cast<uint32_t>(geometry.source_vertices.size());
  copy.first_cluster = static_cast<uint32_t>(geometry.clusters.size());
  copy.first_level_cluster = copy.level_cluster_count = 0;
  // Boxes of deformed geometry would have to be recomputed each frame.
  copy.first_ray_box = copy.ray_box_count = 0;
  for (uint32_t v = 0; v < copy.vertex_count; ++v) {
    geometry.source_vertices.push_back(geometry.source_vertices[source_vertex + v]);
  }
  for (uint32_t c = 0; c < copy.cluster_count; ++c) {
    Cluster cluster = geometry.clusters[source_cluster + c];
    cluster.first_vertex += copy.first_vertex - source_vertex;
    cluster.merged_by = kNone;  // deformed meshes have no LOD
    geometry.clusters.push_back(cluster);
  }
  geometry.primitives.push_back(copy);
}

}  // namespace

bool is_deformed(const Node& node) {
  return node.mesh != kNone &&
         (node.skin != kNone || node.morph_weight_count > 0 || node.has_instance_vertices);
}

bool is_mirrored_by_joints(const Scene& scene, const Node& node) {
  if (node.skin == kNone) return false;
  const Joint& joint = scene.joints[scene.skins[node.skin].first_joint];
  return glm::determinant(glm::mat3(scene.nodes[joint.node].world_from_node * joint.joint_from_mesh)) < 0;
}

uint64_t corners_of_mesh(const Scene& scene, const Mesh& mesh) {
  uint64_t corners = 0;
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    // Upper bound: clusters duplicate a shared vertex at most once per triangle.
    corners += std::max(scene.primitives[p].vertex_count, scene.primitives[p].index_count);
  }
  return corners;
}

uint64_t deformed_corners(const Scene& scene) {
  uint64_t corners = 0;
  for (const Node& node : scene.nodes) {
    if (is_deformed(node)) corners += corners_of_mesh(scene, scene.meshes[node.mesh]);
  }
  return corners;
}

Result<void> check_deformed_copies(const Scene& scene) {
  if (deformed_corners(scene) <= kMaxDeformedCorners) return {};
  return Error{"the nodes with skins or morph targets have more than " + std::to_string(kMaxDeformedCorners) +
               " corners of triangles together, each node counted for itself; show fewer of them"};
}

std::vector<DeformedNode> add_deformed_copies(const Scene& scene, ClusteredGeometry& geometry) {
  std::vector<DeformedNode> nodes;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    if (!is_deformed(scene.nodes[n])) continue;
    nodes.push_back({n, static_cast<uint32_t>(geometry.primitives.size())});
    const Mesh& mesh = scene.meshes[scene.nodes[n].mesh];
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
      copy_primitive(geometry, p);
    }
  }
  return nodes;
}

}  // namespace fire3dv::scene
