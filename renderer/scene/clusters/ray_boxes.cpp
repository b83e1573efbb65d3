#include "renderer/scene/clusters/ray_boxes.h"

#include <algorithm>
#include <cstddef>

#include "renderer/scene/clusters/clusters.h"

namespace fire3dv::scene {
namespace {

// A value with its position, in double, since sums of valid coordinates overflow float.
template <typename T>
struct Centered {
  glm::dvec3 center;
  // Tie-breaker of equal positions, so that the order does not depend on the standard library.
  uint32_t number;
  T value;
};

template <typename T>
int longest_axis(std::span<const Centered<T>> some) {
  glm::dvec3 low = some[0].center, high = low;
  for (const Centered<T>& one : some) {
    low = glm::min(low, one.center);
    high = glm::max(high, one.center);
  }
  const glm::dvec3 size = high - low;
  int axis = size.y > size.x ? 1 : 0;
  if (size.z > size[axis]) axis = 2;
  return axis;
}

// Recursive median split along the longest axis. Ranges of `least` stay unsorted; the first half has a
// multiple of it.
template <typename T>
void sort_into_halves(std::span<Centered<T>> some, size_t least) {
  if (some.size() <= least) return;
  const int axis = longest_axis<T>(some);
  const size_t pieces = (some.size() + least - 1) / least, half = (pieces + 1) / 2 * least;
  std::nth_element(some.begin(), some.begin() + static_cast<ptrdiff_t>(half), some.end(),
                   [axis](const Centered<T>& a, const Centered<T>& b) {
                     return a.center[axis] != b.center[axis] ? a.center[axis] < b.center[axis]
                                                             : a.number < b.number;
                   });
  sort_into_halves(some.first(half), least);
  sort_into_halves(some.subspan(half), least);
}

template <typename T>
void write_back(std::span<const Centered<T>> sorted, std::span<T> values) {
  for (size_t i = 0; i < values.size(); ++i) values[i] = sorted[i].value;
}

}  // namespace

void order_for_ray_boxes(std::span<Corners> triangles, std::span<const glm::vec3> vertices) {
  std::vector<Centered<Corners>> boxes_by_center;
  boxes_by_center.reserve(triangles.size());
  for (const Corners& t : triangles) {
    const glm::dvec3 sum =
        glm::dvec3(vertices[t[0]]) + glm::dvec3(vertices[t[1]]) + glm::dvec3(vertices[t[2]]);
    boxes_by_center.push_back({sum, static_cast<uint32_t>(boxes_by_center.size()), t});
  }
  sort_into_halves<Corners>(boxes_by_center, kRayBoxTriangles);
  write_back<Corners>(boxes_by_center, triangles);
}

std::vector<RayAabb> ray_boxes_of(std::span<const Cluster> clusters, std::span<const uint32_t> triangles,
                                  std::span<const uint32_t> source_vertices,
                                  std::span<const glm::vec3> positions) {
  std::vector<Centered<RayAabb>> boxes_by_center;
  for (const Cluster& cluster : clusters) {
    const auto position = [&](uint32_t vertex) {
      return positions[source_vertices[cluster.first_vertex + vertex]];
    };
    for (uint32_t first = 0; first < cluster.triangle_count; first += kRayBoxTriangles) {
      const uint32_t count = std::min(kRayBoxTriangles, cluster.triangle_count - first);
      RayAabb box;
      box.first_vertex = cluster.first_vertex;
      box.triangles = (cluster.first_triangle + first) | (count - 1) << kRayBoxCountShift;
      box.low = box.high = position(triangles[cluster.first_triangle + first] & 0xff);
      for (uint32_t t = 0; t < count; ++t) {
        const uint32_t packed = triangles[cluster.first_triangle + first + t];
        for (const uint32_t vertex : {packed & 0xff, packed >> 8 & 0xff, packed >> 16}) {
          box.low = glm::min(box.low, position(vertex));
          box.high = glm::max(box.high, position(vertex));
        }
      }
      const glm::dvec3 center = 0.5 * (glm::dvec3(box.low) + glm::dvec3(box.high));
      boxes_by_center.push_back({center, static_cast<uint32_t>(boxes_by_center.size()), box});
    }
  }
  sort_into_halves<RayAabb>(boxes_by_center, 1);
  std::vector<RayAabb> boxes(boxes_by_center.size());
  write_back<RayAabb>(boxes_by_center, boxes);
  return boxes;
}

}  // namespace fire3dv::scene
