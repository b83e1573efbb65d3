// The list of corners that goes with a scene's clusters, for whoever draws or traces it as plain triangles,
// lines or points: ClusteredPrimitive::first_index points into it. It follows from the clusters and is as
// large as all of their positions, so it is written where it is needed and kept nowhere.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/scene/clusters.h"

namespace fire3dv::scene {

uint64_t index_count(const ClusteredGeometry& geometry);

// Refers to both, which must outlive it.
class ClusterIndices {
 public:
  ClusterIndices(const Scene& scene, const ClusteredGeometry& geometry);

  // Those from `first` on, relative to their primitive's first vertex; to: no more than there are. On all
  // cores.
  void write(uint64_t first, std::span<uint32_t> to) const;

 private:
  // Of one cluster, or of a whole primitive that is not cut.
  struct Run {
    uint32_t first_index, index_count;
    const uint32_t* triangles;  // packed, or, where that is null,
    const uint32_t* indices;    // as they are
    uint32_t first_vertex;      // the cluster's, of its primitive's
  };
  static void write(const Run& run, uint64_t first, std::span<uint32_t> to);

  std::vector<Run> runs_;
};

}  // namespace fire3dv::scene
