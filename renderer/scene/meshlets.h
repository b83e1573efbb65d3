// A list of triangles cut into clusters within the limits that the shaders are built for, with their bounds.
#pragma once

#include <span>

#include "renderer/scene/cluster_growth.h"
#include "renderer/scene/clusters.h"

namespace fire3dv::scene {

struct Meshlets {
  GrownClusters grown;

  Meshlets(std::span<const uint32_t> indices, std::span<const glm::vec3> positions);
  // Bounds and counts of one of them; where it lies is the caller's matter.
  Cluster bounded(const GrownClusters::Run& run, std::span<const glm::vec3> positions) const;
};

}  // namespace fire3dv::scene
