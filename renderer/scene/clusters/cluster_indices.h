// Index list of a clustered scene for draws and ray geometry without clusters.
// ClusteredPrimitive::first_index refers to it. It is derived from the clusters and as large as they are, so
// it is generated on demand.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/scene/clusters/clusters.h"

namespace fire3dv::scene {

uint64_t index_count(const ClusteredGeometry& geometry);

// Borrows both arguments.
class ClusterIndices {
 public:
  ClusterIndices(const Scene& scene, const ClusteredGeometry& geometry);

  // Writes indices from `first` on, relative to the first vertex of their primitive, on all cores. `to` must
  // not exceed the list.
  void write(uint64_t first, std::span<uint32_t> to) const;

 private:
  // Source of one cluster, or of an unclustered primitive.
  struct Run {
    uint32_t first_index, index_count;
    const uint32_t* triangles;  // packed; null for unclustered primitives
    const uint32_t* indices;    // then plain indices
    uint32_t first_vertex;      // of the cluster, relative to its primitive
  };
  static void write(const Run& run, uint64_t first, std::span<uint32_t> to);

  std::vector<Run> runs_;
};

}  // namespace fire3dv::scene
