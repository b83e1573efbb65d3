#include "convert/mesh/geometry/mesh_normals.h"

#include <cstddef>
#include <functional>
#include <string_view>
#include <unordered_map>

#include "convert/mesh/mesh_store.h"

namespace fire3dv::convert {
namespace {

// More faces at one vertex are averaged without comparing each pair.
constexpr size_t kMaxCompared = 256;

struct HashPosition {
  size_t operator()(const glm::vec3& p) const {
    return std::hash<std::string_view>()({reinterpret_cast<const char*>(&p), sizeof p});
  }
};

}  // namespace

std::vector<glm::vec3> corner_normals(const std::vector<glm::dvec3>& vertices,
                                      const std::vector<std::array<uint32_t, 3>>& faces,
                                      double least_cosine) {
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
      if (least_cosine > -1 && first[corner + 1] - first[corner] <= kMaxCompared) {
        sum = glm::dvec3(0);
        for (size_t at = first[corner]; at < first[corner + 1]; ++at)
          if (glm::dot(units[i], units[around[at]]) >= least_cosine) sum += areas[around[at]];
      }
      const double length = glm::length(sum);
      normals[3 * i + k] = length > 0 ? glm::vec3(sum / length) : glm::vec3(0, 0, 1);
    }
  }
  return normals;
}

Surface with_normals(const Surface& surface, double least_cosine) {
  std::vector<glm::dvec3> positions;  // without duplicates, which seams of textures have
  std::unordered_map<glm::vec3, uint32_t, HashPosition> index_of;
  std::vector<std::array<uint32_t, 3>> faces(surface.indices.size() / 3);
  for (size_t i = 0; i < 3 * faces.size(); ++i) {
    const glm::vec3 position = surface.positions[surface.indices[i]] + 0.0f;  // -0 equals 0
    const auto [known, is_new] = index_of.try_emplace(position, static_cast<uint32_t>(positions.size()));
    if (is_new) positions.emplace_back(position);
    faces[i / 3][i % 3] = known->second;
  }
  const std::vector<glm::vec3> normals = corner_normals(positions, faces, least_cosine);
  SurfaceBuilder builder(true, !surface.uvs.empty(), !surface.colors.empty());
  for (size_t i = 0; i < 3 * faces.size(); i += 3) {
    SurfaceBuilder::Corner corners[3];
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t vertex = surface.indices[i + k];
      corners[k].position = surface.positions[vertex];
      corners[k].normal = normals[i + k];
      if (!surface.uvs.empty()) corners[k].uv = surface.uvs[vertex];
      if (!surface.colors.empty()) corners[k].color = surface.colors[vertex];
    }
    (void)builder.add(corners[0], corners[1], corners[2]);  // positions are finite: they come from a mesh
  }
  Surface result = builder.take();
  result.material = surface.material;
  return result;
}

}  // namespace fire3dv::convert
