#include "renderer/scene/model/surface_area.h"

namespace fire3dv::scene {

std::array<glm::vec3, 3> triangle_corners(const Scene& scene, const Primitive& primitive, uint32_t triangle,
                                          const glm::mat4& world_from_node) {
  std::array<glm::vec3, 3> corners;
  for (uint32_t k = 0; k < 3; ++k) {
    const uint32_t index = scene.indices[primitive.first_index + 3 * triangle + k];
    corners[k] = glm::vec3(world_from_node * glm::vec4(scene.positions[primitive.first_vertex + index], 1));
  }
  return corners;
}

double area_of(const std::array<glm::vec3, 3>& triangle) {
  const glm::dvec3 a(triangle[0]), b(triangle[1]), c(triangle[2]);
  return 0.5 * glm::length(glm::cross(b - a, c - a));
}

double surface_area(const Scene& scene, const Primitive& primitive, const glm::mat4& world_from_node) {
  double area = 0;
  const TriangleSample sample(primitive);
  for (uint32_t t = 0; t < sample.count; t += sample.step)
    area += area_of(triangle_corners(scene, primitive, t, world_from_node));
  return area * sample.step;
}

double surface_area(const Scene& scene, const Node& node, const glm::mat4& world_from_node) {
  if (node.mesh == kNone) return 0;
  double area = 0;
  const Mesh& mesh = scene.meshes[node.mesh];
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p)
    area += surface_area(scene, scene.primitives[p], world_from_node);
  return area;
}

}  // namespace fire3dv::scene
