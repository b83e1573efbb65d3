// Cluster builder for triangle lists, and its results within the limits of the shaders: meshlets with
// bounding spheres and normal cones.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/scene/clusters/clusters.h"

namespace fire3dv::scene {

// Clusters in concatenated arrays.
struct GrownClusters {
  struct Run {
    uint32_t first_vertex, vertex_count;      // range of `vertices`
    uint32_t first_triangle, triangle_count;  // range of `corners`, three per triangle
  };
  std::vector<Run> runs;
  std::vector<uint32_t> vertices;  // vertex of the input list
  std::vector<uint8_t> corners;    // cluster-local vertex indices; triangles in input order
};

struct GrowthLimits {
  uint32_t vertices, triangles;  // per cluster; at most 255, at least 3 and 1
  float cone_weight;             // 0: position only, 1: normals only
};

// Greedy cluster builder for triangle lists. A cluster grows over adjacent triangles: first those that need
// no new vertex or would be left alone, then near ones with similar normals. The next cluster starts at its
// border. indices: three per triangle, each below positions.size().
GrownClusters grow_clusters(std::span<const uint32_t> indices, std::span<const glm::vec3> positions,
                            const GrowthLimits& limits);

// Clusters within the limits of the shaders.
struct Meshlets {
  GrownClusters grown;

  Meshlets(std::span<const uint32_t> indices, std::span<const glm::vec3> positions);
  // Bounds and counts of one cluster; the caller sets its offsets.
  Cluster bounded(const GrownClusters::Run& run, std::span<const glm::vec3> positions) const;
};

}  // namespace fire3dv::scene
