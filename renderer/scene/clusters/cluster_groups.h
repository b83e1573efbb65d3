// Cluster grouping for LOD simplification: groups of adjacent clusters with short borders (greedy). The
// result is deterministic.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace fire3dv::scene {

// Edge of exactly one triangle of the cluster, between two welded positions.
using OpenEdge = uint64_t;
// place_of_corner: welded position of each corner, three per triangle.
std::vector<OpenEdge> open_edges(std::span<const uint32_t> place_of_corner);

struct ClusterGroups {
  std::vector<uint32_t> members;
  std::vector<uint32_t> first{0};  // group g has members first[g] to first[g + 1]
  size_t count() const { return first.size() - 1; }
  std::span<const uint32_t> group(size_t g) const {
    return {members.data() + first[g], first[g + 1] - first[g]};
  }
};

// edges_of: open edges of each cluster. Clusters without shared edges are grouped in their order.
ClusterGroups group_neighbours(std::span<const std::vector<OpenEdge>* const> edges_of);

}  // namespace fire3dv::scene
