// Boxes of few triangles for ray tracing: AABBs over up to 16 adjacent triangles each, in the order of a
// balanced tree. For devices on which a BLAS over all triangles is too expensive (gpu/acceleration.h). The
// shader intersects the triangles of a box one by one.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace fire3dv::scene {

struct Cluster;

// Measured on lavapipe: half as many slow down the start, twice as many slow down each ray.
constexpr uint32_t kRayBoxTriangles = 16;
constexpr uint32_t kRayBoxCountShift = 28;
constexpr uint32_t kMaxRayBoxTriangles = 1u << kRayBoxCountShift;  // per scene

// Bounds of consecutive triangles of one cluster, uploaded as is: low and high are a VkAabbPositionsKHR, the
// rest is gpu_types::RayBoxRecord.
struct RayAabb {
  glm::vec3 low{0}, high{0};  // node space
  uint32_t first_vertex = 0;  // first vertex of the cluster
  // First triangle in ClusteredGeometry::triangles; bits from kRayBoxCountShift on: count minus one.
  uint32_t triangles = 0;

  uint32_t first_triangle() const { return triangles & (kMaxRayBoxTriangles - 1); }
  uint32_t triangle_count() const { return (triangles >> kRayBoxCountShift) + 1; }
};

// Cluster-local vertex indices of a triangle.
using Corners = std::array<uint8_t, 3>;

// Sorts a cluster's triangles so that those of one box are adjacent in space.
void order_for_ray_boxes(std::span<Corners> triangles, std::span<const glm::vec3> vertices);

// Boxes of one primitive. triangles: as in ClusteredGeometry; source_vertices: indices into positions. Each
// cluster must be sorted by order_for_ray_boxes().
std::vector<RayAabb> ray_boxes_of(std::span<const Cluster> clusters, std::span<const uint32_t> triangles,
                                  std::span<const uint32_t> source_vertices,
                                  std::span<const glm::vec3> positions);

}  // namespace fire3dv::scene
