#include "renderer/scene/tangents.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace fire3dv::scene {
namespace {

struct Sum {
  glm::vec3 tangent{0};
  float orientation = 0;  // > 0: more of the vertex has a right-handed frame than a mirrored one
};

glm::vec3 normalized_or(const glm::vec3& vector, const glm::vec3& otherwise) {
  const float length = std::sqrt(glm::dot(vector, vector));
  return length > 1e-20f && std::isfinite(length) ? vector / length : otherwise;
}

float angle_between(const glm::vec3& a, const glm::vec3& b) {
  const glm::vec3 none(0);
  return std::acos(std::clamp(glm::dot(normalized_or(a, none), normalized_or(b, none)), -1.0f, 1.0f));
}

// Any direction in the surface, where u gives none.
glm::vec3 perpendicular_to(const glm::vec3& normal) {
  const glm::vec3 axis = std::abs(normal.x) < 0.9f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
  return normalized_or(axis - normal * glm::dot(axis, normal), glm::vec3(1, 0, 0));
}

}  // namespace

void generate_tangents(std::span<const glm::vec3> positions, std::span<VertexAttributes> attributes,
                       std::span<const uint32_t> indices, uint32_t uv_set) {
  const auto uv = [&](uint32_t vertex) {
    return uv_set == 0 ? attributes[vertex].uv0 : attributes[vertex].uv1;
  };
  std::vector<Sum> sums(positions.size());
  for (size_t i = 0; i + 2 < indices.size(); i += 3) {
    const uint32_t corner[3] = {indices[i], indices[i + 1], indices[i + 2]};
    const glm::vec3 edge1 = positions[corner[1]] - positions[corner[0]],
                    edge2 = positions[corner[2]] - positions[corner[0]];
    const glm::vec2 uv1 = uv(corner[1]) - uv(corner[0]), uv2 = uv(corner[2]) - uv(corner[0]);
    const float area = uv1.x * uv2.y - uv1.y * uv2.x;
    if (area == 0 || !std::isfinite(area)) continue;
    const float orientation = area > 0 ? 1.0f : -1.0f;
    const glm::vec3 rising_u = (edge1 * uv2.y - edge2 * uv1.y) * orientation;
    for (int c = 0; c < 3; ++c) {
      const glm::vec3& here = positions[corner[c]];
      const glm::vec3& normal = attributes[corner[c]].normal;
      const float angle =
          angle_between(positions[corner[(c + 1) % 3]] - here, positions[corner[(c + 2) % 3]] - here);
      Sum& sum = sums[corner[c]];
      sum.tangent += angle * normalized_or(rising_u - normal * glm::dot(normal, rising_u), glm::vec3(0));
      sum.orientation += angle * orientation;
    }
  }
  for (size_t vertex = 0; vertex < attributes.size(); ++vertex) {
    const glm::vec3 tangent =
        normalized_or(sums[vertex].tangent, perpendicular_to(attributes[vertex].normal));
    attributes[vertex].tangent = glm::vec4(tangent, sums[vertex].orientation < 0 ? -1.0f : 1.0f);
  }
}

}  // namespace fire3dv::scene
