// Boxes around a few neighbouring triangles each, in the order of a tree whose halves have as many of them.
// For devices whose own structure over all triangles costs more than the frames that it serves
// (gpu/acceleration.h): they trace rays to such a box, and its triangles are met one by one.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace fire3dv::scene {

struct Cluster;

// Measured on lavapipe: with half as many a start takes longer, with twice as many each ray.
constexpr uint32_t kRayBoxTriangles = 16;
constexpr uint32_t kRayBoxCountShift = 28;
constexpr uint32_t kMostRayBoxTriangles = 1u << kRayBoxCountShift;  // of a scene

// Of up to kRayBoxTriangles triangles of one cluster that follow each other. Uploaded as it is: the box is
// what Vulkan calls VkAabbPositionsKHR, the rest gpu_types::RayBoxRecord's.
struct RayBox {
  glm::vec3 low{0}, high{0};  // node space
  uint32_t first_vertex = 0;  // the cluster's
  uint32_t triangles =
      0;  // the first one of ClusteredGeometry::triangles; above kRayBoxCountShift how many, less one

  uint32_t first_triangle() const { return triangles & (kMostRayBoxTriangles - 1); }
  uint32_t triangle_count() const { return (triangles >> kRayBoxCountShift) + 1; }
};

// Of a triangle, the numbers of its corners.
using Corners = std::array<uint8_t, 3>;

// Puts a cluster's triangles in an order in which those that share a box are neighbours.
void order_for_ray_boxes(std::span<Corners> triangles, std::span<const glm::vec3> vertices);

// Of one primitive. triangles: as ClusteredGeometry's; source_vertices: into positions. Each cluster's
// triangles are in the order above.
std::vector<RayBox> ray_boxes_of(std::span<const Cluster> clusters, std::span<const uint32_t> triangles,
                                 std::span<const uint32_t> source_vertices,
                                 std::span<const glm::vec3> positions);

}  // namespace fire3dv::scene
