#include "renderer/passes/view/facing.h"

#include <cmath>

#include "renderer/passes/view/framing.h"
#include "renderer/passes/view/view.h"
#include "renderer/scene/model/bounds.h"

namespace fire3dv::passes {
namespace {

constexpr size_t kMaxTriangles = 200'000;
constexpr float kHardlyAny = 0.01f;

bool is_drawn(const scene::Scene& scene, const scene::SceneEdits* edits, uint32_t node) {
  return scene.nodes[node].mesh != scene::kNone && !scene::is_unbounded(scene, node) &&
         !(edits && edits->is_hidden(node));
}

template <typename Visit>
void for_each_primitive(const scene::Scene& scene, const scene::SceneEdits* edits, Visit&& visit) {
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    if (!is_drawn(scene, edits, n)) continue;
    const scene::Mesh& mesh = scene.meshes[scene.nodes[n].mesh];
    for (uint32_t p = 0; p < mesh.primitive_count; ++p) visit(n, scene.primitives[mesh.first_primitive + p]);
  }
}

// The share does not depend on the pose, or cannot be told from the rest pose.
bool is_always_front(const scene::Scene& scene, const scene::Primitive& primitive) {
  return primitive.topology != scene::Topology::triangles || primitive.first_influence != scene::kNone ||
         primitive.morph_target_count > 0 ||
         (primitive.material < scene.materials.size() && scene.materials[primitive.material].double_sided);
}

}  // namespace

float front_facing_share(const scene::Scene& scene, const scene::SceneEdits* edits,
                         std::span<const glm::mat4> world_from_node, const glm::vec4& eye_world) {
  size_t triangles = 0;
  bool any_always = false;
  for_each_primitive(scene, edits, [&](uint32_t, const scene::Primitive& primitive) {
    triangles += primitive.index_count / 3;
    any_always |= is_always_front(scene, primitive);
  });
  if (any_always) return 1;
  const size_t stride = triangles / kMaxTriangles + 1;
  double front = 0, all = 0;
  size_t next = 0;  // index of the triangle to look at, from the primitive's first one on
  for_each_primitive(scene, edits, [&](uint32_t node, const scene::Primitive& primitive) {
    const glm::dmat4 world(world_from_node[node]);
    const double winding = glm::determinant(glm::dmat3(world)) < 0 ? -1 : 1;
    const size_t count = primitive.index_count / 3;
    for (; next < count; next += stride) {
      glm::dvec3 corners[3];
      for (size_t c = 0; c < 3; ++c) {
        const uint32_t vertex = primitive.first_vertex + scene.indices[primitive.first_index + 3 * next + c];
        corners[c] = glm::dvec3(world * glm::dvec4(glm::dvec3(scene.positions[vertex]), 1));
      }
      const glm::dvec3 normal = winding * glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
      const double area = glm::length(normal);
      if (!std::isfinite(area)) continue;
      const glm::dvec3 to_eye = glm::dvec3(eye_world) - static_cast<double>(eye_world.w) * corners[0];
      all += area;
      if (glm::dot(normal, to_eye) > 0) front += area;
    }
    next -= count;
  });
  return all > 0 ? static_cast<float>(front / all) : 1;
}

glm::mat4 default_orientation(const scene::Scene& scene, std::span<const glm::mat4> world_from_node) {
  glm::mat4 usual = default_orientation();
  if (scene.view_from != glm::vec3(0)) {
    usual = look_at_pose(scene.view_from, glm::vec3(0));
    usual[3] = glm::vec4(0, 0, 0, 1);
  }
  const glm::vec3 to_eye(usual[2]);  // a camera looks along -z
  if (front_facing_share(scene, nullptr, world_from_node, glm::vec4(to_eye, 0)) >= kHardlyAny) return usual;
  const glm::vec3 others[] = {
      {-to_eye.x, to_eye.y, -to_eye.z}, {to_eye.x, -to_eye.y, to_eye.z}, {-to_eye.x, -to_eye.y, -to_eye.z}};
  for (const glm::vec3& other : others) {
    if (front_facing_share(scene, nullptr, world_from_node, glm::vec4(other, 0)) < kHardlyAny) continue;
    glm::mat4 pose = look_at_pose(other, glm::vec3(0));
    pose[3] = glm::vec4(0, 0, 0, 1);
    return pose;
  }
  return usual;
}

}  // namespace fire3dv::passes
