#include "convert/mesh/smooth_surface.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "convert/mesh/geometry/mesh_normals.h"
#include "convert/mesh/mesh_store.h"

namespace fire3dv::convert {
namespace {

struct HashPosition {
  size_t operator()(const glm::vec3& p) const {
    return std::hash<std::string_view>()({reinterpret_cast<const char*>(&p), sizeof p});
  }
};

}  // namespace

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
  const std::vector<glm::vec3> normals =
      corner_normals(positions, faces, least_cosine, NormalWeights::area_and_angle);
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
