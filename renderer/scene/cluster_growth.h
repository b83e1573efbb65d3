// Cuts a list of triangles into clusters: each grows from a triangle over its neighbours, those first that
// need no vertex more, that would else be left alone, and that lie near and face the same way; the next one
// begins at its border.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace fire3dv::scene {

// Arrays of all clusters, one behind the other.
struct GrownClusters {
  struct Run {
    uint32_t first_vertex, vertex_count;      // in vertices
    uint32_t first_triangle, triangle_count;  // in corners, which has three of each
  };
  std::vector<Run> runs;
  std::vector<uint32_t> vertices;  // of the list
  std::vector<uint8_t> corners;    // in the cluster's own vertices; triangles in the list's order
};

struct GrowthLimits {
  uint32_t vertices, triangles;  // of a cluster; at most 255, and at least 3 and 1
  float cone_weight;             // 0: only places count, 1: only directions
};

// indices: three of each triangle, below the number of positions.
GrownClusters grow_clusters(std::span<const uint32_t> indices, std::span<const glm::vec3> positions,
                            const GrowthLimits& limits);

}  // namespace fire3dv::scene
