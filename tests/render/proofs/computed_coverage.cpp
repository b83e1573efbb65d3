// CPU rasterizer with homogeneous edge functions, and CPU skinning.
#include "tests/render/proofs/computed_coverage.h"

#include <algorithm>
#include <vector>

#include "renderer/scene/clusters/clusters.h"

namespace fire3dv::test {
namespace {

glm::dvec3 world_position(const scene::Scene& scene, const scene::Node& node,
                          const scene::Primitive& primitive, uint32_t vertex) {
  glm::dvec3 position = scene.positions[primitive.first_vertex + vertex];
  for (uint32_t t = 0; t < primitive.morph_target_count; ++t) {
    const size_t delta = primitive.first_morph_delta + size_t{t} * primitive.vertex_count + vertex;
    position += static_cast<double>(scene.morph_weights[node.first_morph_weight + t]) *
                glm::dvec3(scene.morph_deltas[delta].position);
  }
  if (node.skin == scene::kNone || primitive.first_influence == scene::kNone)
    return glm::dmat4(node.world_from_node) * glm::dvec4(position, 1);
  glm::dvec4 sum(0);
  for (uint32_t s = 0; s < primitive.influence_sets; ++s) {
    const scene::Influences& set =
        scene.influences[primitive.first_influence + size_t{vertex} * primitive.influence_sets + s];
    for (size_t i = 0; i < set.joints.size(); ++i) {
      const scene::Joint& joint = scene.joints[scene.skins[node.skin].first_joint + set.joints[i]];
      sum +=
          static_cast<double>(set.weights[i]) * (glm::dmat4(scene.nodes[joint.node].world_from_node) *
                                                 glm::dmat4(joint.joint_from_mesh) * glm::dvec4(position, 1));
    }
  }
  return sum;
}

bool can_be_computed(const scene::Scene& scene, const scene::Primitive& primitive) {
  const scene::Material& material = scene.materials[primitive.material];
  return primitive.topology == scene::Topology::triangles &&
         material.alpha_mode == scene::AlphaMode::opaque && material.transmission == 0;
}

struct Triangles {
  const glm::dmat4 clip_from_world;
  const uint32_t side;
  std::vector<bool> covered;

  // Vertices are in clip space. Homogeneous edge functions need no clipping: behind the eye they change sign.
  void add(const glm::dvec4& a, const glm::dvec4& b, const glm::dvec4& c, bool double_sided, bool mirrored) {
    const glm::dmat3 corners(glm::dvec3(a.x, a.y, a.w), glm::dvec3(b.x, b.y, b.w), glm::dvec3(c.x, c.y, c.w));
    const double determinant = glm::determinant(corners);
    if (determinant == 0 || (!double_sided && (determinant < 0) == mirrored)) return;
    const glm::dmat3 weights_from_pixel = glm::inverse(corners);
    for (uint32_t y = 0; y < side; ++y) {
      for (uint32_t x = 0; x < side; ++x) {
        const glm::dvec3 weights =
            weights_from_pixel * glm::dvec3(2 * (x + 0.5) / side - 1, 2 * (y + 0.5) / side - 1, 1);
        if (weights.x >= 0 && weights.y >= 0 && weights.z >= 0) covered[size_t{y} * side + x] = true;
      }
    }
  }
};

}  // namespace

std::optional<uint32_t> computed_coverage(const scene::Scene& scene, const passes::View& view,
                                          uint32_t side) {
  Triangles triangles{view.clip_from_world, side, std::vector<bool>(size_t{side} * side)};
  for (const scene::Node& node : scene.nodes) {
    if (node.mesh == scene::kNone) continue;
    const scene::Mesh& mesh = scene.meshes[node.mesh];
    const bool mirrored = node.skin != scene::kNone ? scene::is_mirrored_by_joints(scene, node)
                                                    : glm::determinant(glm::dmat3(node.world_from_node)) < 0;
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
      const scene::Primitive& primitive = scene.primitives[p];
      if (!can_be_computed(scene, primitive)) return {};
      std::vector<glm::dvec4> corners;
      for (uint32_t v = 0; v < primitive.vertex_count; ++v)
        corners.push_back(triangles.clip_from_world *
                          glm::dvec4(world_position(scene, node, primitive, v), 1));
      for (uint32_t i = primitive.first_index; i + 2 < primitive.first_index + primitive.index_count;
           i += 3) {
        triangles.add(corners[scene.indices[i]], corners[scene.indices[i + 1]], corners[scene.indices[i + 2]],
                      scene.materials[primitive.material].double_sided, mirrored);
      }
    }
  }
  return static_cast<uint32_t>(std::count(triangles.covered.begin(), triangles.covered.end(), true));
}

}  // namespace fire3dv::test
