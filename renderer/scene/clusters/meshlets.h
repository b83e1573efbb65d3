// Cluster builder within the limits of the shaders, with bounding spheres and normal cones.
#pragma once

#include <span>

#include "renderer/scene/clusters/cluster_growth.h"
#include "renderer/scene/clusters/clusters.h"

namespace fire3dv::scene {

struct Meshlets {
  GrownClusters grown;

  Meshlets(std::span<const uint32_t> indices, std::span<const glm::vec3> positions);
  // Bounds and counts of one cluster; the caller sets its offsets.
  Cluster bounded(const GrownClusters::Run& run, std::span<const glm::vec3> positions) const;
};

}  // namespace fire3dv::scene
