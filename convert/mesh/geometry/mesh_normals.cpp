#include "convert/mesh/geometry/mesh_normals.h"

#include <cmath>
#include <cstddef>

namespace fire3dv::convert {
namespace {

// More faces at one vertex are averaged without comparing each pair.
constexpr size_t kMaxCompared = 256;

double angle_at(const glm::dvec3& vertex, const glm::dvec3& next, const glm::dvec3& last) {
  const glm::dvec3 a = next - vertex, b = last - vertex;
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

}  // namespace

std::vector<glm::vec3> corner_normals(const std::vector<glm::dvec3>& vertices,
                                      const std::vector<std::array<uint32_t, 3>>& faces, double least_cosine,
                                      NormalWeights weights) {
  std::vector<glm::dvec3> units(faces.size()), means(vertices.size(), glm::dvec3(0));
  std::vector<glm::dvec3> weighted(3 * faces.size());  // normal of the face of each corner
  std::vector<size_t> first(vertices.size() + 1, 0);   // of a vertex in `around`
  for (size_t i = 0; i < faces.size(); ++i) {
    const std::array<uint32_t, 3>& face = faces[i];
    const glm::dvec3 area =
        glm::cross(vertices[face[1]] - vertices[face[0]], vertices[face[2]] - vertices[face[0]]);
    const double length = glm::length(area);
    units[i] = length > 0 ? area / length : glm::dvec3(0);
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t corner = face[k];
      const double weight =
          weights == NormalWeights::area
              ? 1
              : angle_at(vertices[corner], vertices[face[(k + 1) % 3]], vertices[face[(k + 2) % 3]]);
      weighted[3 * i + k] = weight * area;
      means[corner] += weighted[3 * i + k];
      ++first[corner + 1];
    }
  }
  for (size_t v = 0; v < vertices.size(); ++v) first[v + 1] += first[v];
  std::vector<size_t> around(3 * faces.size()), filled(first.begin(), first.end() - 1);
  for (size_t i = 0; i < 3 * faces.size(); ++i) around[filled[faces[i / 3][i % 3]]++] = i;

  std::vector<glm::vec3> normals(3 * faces.size());
  for (size_t i = 0; i < normals.size(); ++i) {
    const uint32_t corner = faces[i / 3][i % 3];
    glm::dvec3 sum = means[corner];
    if (least_cosine > -1 && first[corner + 1] - first[corner] <= kMaxCompared) {
      sum = glm::dvec3(0);
      for (size_t at = first[corner]; at < first[corner + 1]; ++at)
        if (glm::dot(units[i / 3], units[around[at] / 3]) >= least_cosine) sum += weighted[around[at]];
    }
    const double length = glm::length(sum);
    normals[i] = length > 0 ? glm::vec3(sum / length) : glm::vec3(0, 0, 1);
  }
  return normals;
}

}  // namespace fire3dv::convert
