#include "convert/mesh/geometry/mesh_normals.h"

#include <cstddef>

namespace fire3dv::convert {
namespace {

constexpr double kMinCosine = 0.8;
// More faces at one vertex are averaged without comparing each pair.
constexpr size_t kMaxCompared = 64;

}  // namespace

std::vector<glm::vec3> corner_normals(const std::vector<glm::dvec3>& vertices,
                                      const std::vector<std::array<uint32_t, 3>>& faces, bool smooth) {
  std::vector<glm::dvec3> areas(faces.size()), units(faces.size()), means(vertices.size(), glm::dvec3(0));
  std::vector<size_t> first(vertices.size() + 1, 0);  // of a vertex in `around`
  for (size_t i = 0; i < faces.size(); ++i) {
    const std::array<uint32_t, 3>& face = faces[i];
    areas[i] = glm::cross(vertices[face[1]] - vertices[face[0]], vertices[face[2]] - vertices[face[0]]);
    const double length = glm::length(areas[i]);
    units[i] = length > 0 ? areas[i] / length : glm::dvec3(0);
    for (const uint32_t corner : face) {
      means[corner] += areas[i];
      ++first[corner + 1];
    }
  }
  for (size_t v = 0; v < vertices.size(); ++v) first[v + 1] += first[v];
  std::vector<size_t> around(3 * faces.size()), filled(first.begin(), first.end() - 1);
  for (size_t i = 0; i < faces.size(); ++i)
    for (const uint32_t corner : faces[i]) around[filled[corner]++] = i;

  std::vector<glm::vec3> normals(3 * faces.size());
  for (size_t i = 0; i < faces.size(); ++i) {
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t corner = faces[i][k];
      glm::dvec3 sum = means[corner];
      if (!smooth && first[corner + 1] - first[corner] <= kMaxCompared) {
        sum = glm::dvec3(0);
        for (size_t at = first[corner]; at < first[corner + 1]; ++at)
          if (glm::dot(units[i], units[around[at]]) >= kMinCosine) sum += areas[around[at]];
      }
      const double length = glm::length(sum);
      normals[3 * i + k] = length > 0 ? glm::vec3(sum / length) : glm::vec3(0, 0, 1);
    }
  }
  return normals;
}

}  // namespace fire3dv::convert
