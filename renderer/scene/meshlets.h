// A list of triangles cut into clusters within the limits that the shaders are built for, with their bounds.
#pragma once

#include <meshoptimizer.h>

#include <span>
#include <vector>

#include "renderer/scene/clusters.h"

namespace fire3dv::scene {

// Kept from one list to the next, for its memory.
struct Meshlets {
  std::vector<meshopt_Meshlet> meshlets;
  std::vector<unsigned int> vertices;
  std::vector<unsigned char> triangles;
  size_t count = 0;

  void cut(std::span<const uint32_t> indices, const glm::vec3* positions, size_t vertex_count);
  // Bounds and counts of one of them; where it lies is the caller's matter.
  Cluster bounded(size_t meshlet, const glm::vec3* positions, size_t vertex_count) const;
};

}  // namespace fire3dv::scene
