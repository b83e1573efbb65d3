// Uniform grid of triangles for nearest-point queries. Not thread-safe, since queries mark visited triangles.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace fire3dv::scene {

class TriangleGrid {
 public:
  TriangleGrid(std::span<const glm::vec3> positions, std::span<const uint32_t> indices);

  float cell() const { return cell_; }

  // Calls visitor(triangle) once per triangle whose cell is closer than enough(), in rings of cells from near
  // to far. enough() is evaluated again for each ring.
  template <typename Visitor, typename Enough>
  void visit(const glm::vec3& point, const Visitor& visitor, const Enough& enough) {
    ++visit_;
    const glm::ivec3 center = cell_at(point);
    // Distance to the border of the cell; points outside the grid are farther from all triangles.
    const glm::vec3 inside = point - low_ - glm::vec3(center) * cell_;
    const glm::vec3 to_border = glm::max(glm::min(inside, cell_ - inside), glm::vec3(0));
    const float border = std::min(to_border.x, std::min(to_border.y, to_border.z));
    for (int ring = 0; ring < kSide; ++ring) {
      if (ring > 0 && border + static_cast<float>(ring - 1) * cell_ > enough()) return;
      const glm::ivec3 low = glm::max(center - ring, glm::ivec3(0)),
                       high = glm::min(center + ring, size_ - 1);
      for (int z = low.z; z <= high.z; ++z) {
        for (int y = low.y; y <= high.y; ++y) {
          const bool face =
              z == center.z - ring || z == center.z + ring || y == center.y - ring || y == center.y + ring;
          for (int x = low.x; x <= high.x; ++x) {
            if (face || x == center.x - ring || x == center.x + ring) visit_cell({x, y, z}, visitor);
          }
        }
      }
    }
  }

 private:
  static constexpr int kSide = 24;  // maximum cells per side

  glm::ivec3 cell_at(const glm::vec3& point) const {
    return glm::clamp(glm::ivec3((point - low_) * inverse_cell_), glm::ivec3(0), size_ - 1);
  }
  size_t index(const glm::ivec3& cell) const {
    return static_cast<size_t>((cell.z * size_.y + cell.y) * size_.x + cell.x);
  }
  template <typename Visitor>
  void visit_cell(const glm::ivec3& cell, const Visitor& visitor) {
    const size_t i = index(cell);
    for (uint32_t t = first_[i]; t < first_[i + 1]; ++t) {
      uint32_t& seen = seen_[triangles_[t]];
      if (seen == visit_) continue;
      seen = visit_;
      visitor(triangles_[t]);
    }
  }

  glm::vec3 low_{0};
  float cell_ = 1, inverse_cell_ = 1;
  glm::ivec3 size_{1};
  std::vector<uint32_t> first_, triangles_, seen_;
  uint32_t visit_ = 0;
};

}  // namespace fire3dv::scene
