// Ray casting on the CPU in double precision.
#include "tests/render/proofs/cast_rays.h"

namespace fire3dv::test {

std::vector<Face> faces_of(const scene::Scene& scene, const std::vector<glm::mat4>& world_from_node) {
  std::vector<Face> faces;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    if (scene.nodes[n].mesh == scene::kNone) continue;
    const scene::Mesh& mesh = scene.meshes[scene.nodes[n].mesh];
    const glm::dmat4 world_from_mesh(world_from_node[n]);
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
      const scene::Primitive& primitive = scene.primitives[p];
      for (uint32_t i = 0; i < primitive.index_count; i += 3) {
        Face& face = faces.emplace_back();
        face.instance = n + 1;
        for (uint32_t c = 0; c < 3; ++c) {
          const uint32_t vertex = primitive.first_vertex + scene.indices[primitive.first_index + i + c];
          face.corner_world[c] =
              glm::dvec3(world_from_mesh * glm::dvec4(glm::dvec3(scene.positions[vertex]), 1));
        }
      }
    }
  }
  return faces;
}

glm::dvec3 Eye::ray_world(glm::dvec2 place) const {
  const passes::Intrinsics& k = intrinsics;
  return glm::dmat3(world_from_camera) *
         glm::dvec3((place.x - static_cast<double>(k.cx_px)) / static_cast<double>(k.fx_px),
                    -(place.y - static_cast<double>(k.cy_px)) / static_cast<double>(k.fy_px), -1);
}

std::optional<double> Eye::depth_of(const Face& face, glm::dvec2 place) const {
  const glm::dvec3 eye(world_from_camera[3]), ray = ray_world(place);
  const glm::dvec3 a = face.corner_world[0] - eye, b = face.corner_world[1] - eye,
                   c = face.corner_world[2] - eye;
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  if (glm::dot(normal, ray) >= 0) return std::nullopt;  // back face
  // Inside test against each plane through the eye and an edge.
  for (const glm::dvec3& side : {glm::cross(b, a), glm::cross(c, b), glm::cross(a, c)}) {
    if (glm::dot(ray, side) < 0) return std::nullopt;
  }
  const double depth = glm::dot(normal, a) / glm::dot(normal, ray);
  return depth > 0 ? std::optional(depth) : std::nullopt;
}

Hit Eye::cast(const std::vector<Face>& faces, glm::dvec2 place) const {
  Hit nearest;
  for (size_t i = 0; i < faces.size(); ++i) {
    const std::optional<double> depth = depth_of(faces[i], place);
    if (!depth || (nearest.instance && nearest.depth_m <= *depth)) continue;
    const glm::dvec3* corner = faces[i].corner_world;
    nearest = {faces[i].instance, i, *depth, glm::dvec3(world_from_camera[3]) + *depth * ray_world(place),
               glm::normalize(glm::cross(corner[1] - corner[0], corner[2] - corner[0]))};
  }
  return nearest;
}

std::optional<Hit> Eye::cast_surely(const std::vector<Face>& faces, glm::dvec2 place) const {
  const Hit hit = cast(faces, place);
  for (const glm::dvec2 beside :
       {glm::dvec2(1, 1), glm::dvec2(-1, 1), glm::dvec2(1, -1), glm::dvec2(-1, -1)}) {
    if (cast(faces, place + 0.01 * beside).face != hit.face) return std::nullopt;
  }
  return hit;
}

glm::dvec2 Eye::project(const glm::dvec3& world) const {
  const glm::dvec3 p(glm::inverse(world_from_camera) * glm::dvec4(world, 1));
  const passes::Intrinsics& k = intrinsics;
  return {static_cast<double>(k.fx_px) * p.x / -p.z + static_cast<double>(k.cx_px),
          -static_cast<double>(k.fy_px) * p.y / -p.z + static_cast<double>(k.cy_px)};
}

}  // namespace fire3dv::test
