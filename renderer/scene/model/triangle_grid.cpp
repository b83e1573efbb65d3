#include "renderer/scene/model/triangle_grid.h"

#include <cmath>

namespace fire3dv::scene {

TriangleGrid::TriangleGrid(std::span<const glm::vec3> positions, std::span<const uint32_t> indices) {
  const size_t count = indices.size() / 3;
  glm::vec3 low(INFINITY), high(-INFINITY);
  for (uint32_t index : indices) {
    low = glm::min(low, positions[index]);
    high = glm::max(high, positions[index]);
  }
  if (count == 0) low = high = glm::vec3(0);
  low_ = low;
  // Cells per side: a surface of n triangles spans about sqrt(n / 2) of them.
  const glm::vec3 extent = high - low;
  const float longest = std::max(extent.x, std::max(extent.y, extent.z));
  const float across = std::clamp(std::sqrt(0.5f * static_cast<float>(count)), 1.0f, kSide - 1.0f);
  cell_ = longest > 0 ? longest / across : 1.0f;
  inverse_cell_ = 1 / cell_;
  if (!std::isfinite(inverse_cell_)) cell_ = inverse_cell_ = 1;
  size_ = glm::clamp(glm::ivec3(extent * inverse_cell_) + 1, glm::ivec3(1), glm::ivec3(kSide));
  first_.assign(index(size_ - 1) + 2, 0);
  seen_.assign(count, 0);
  auto each_cell = [&](size_t triangle, auto&& use) {
    const glm::vec3 a = positions[indices[3 * triangle]], b = positions[indices[3 * triangle + 1]],
                    c = positions[indices[3 * triangle + 2]];
    const glm::ivec3 from = cell_at(glm::min(a, glm::min(b, c))), to = cell_at(glm::max(a, glm::max(b, c)));
    for (int z = from.z; z <= to.z; ++z) {
      for (int y = from.y; y <= to.y; ++y) {
        for (int x = from.x; x <= to.x; ++x) use(index({x, y, z}));
      }
    }
  };
  for (size_t t = 0; t < count; ++t) each_cell(t, [&](size_t cell) { ++first_[cell + 1]; });
  for (size_t cell = 0; cell + 1 < first_.size(); ++cell) first_[cell + 1] += first_[cell];
  triangles_.resize(first_.back());
  std::vector<uint32_t> next = first_;
  for (size_t t = 0; t < count; ++t) {
    each_cell(t, [&](size_t cell) { triangles_[next[cell]++] = static_cast<uint32_t>(t); });
  }
}

}  // namespace fire3dv::scene
