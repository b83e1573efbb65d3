// Which clusters are simplified together: groups of neighbours, with as short a border around them as a
// greedy choice finds. Depends on nothing but its input.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace fire3dv::scene {

// An edge that only one triangle of the cluster has, between two places in space.
using OpenEdge = uint64_t;
// place_of_corner: three for each triangle.
std::vector<OpenEdge> open_edges(std::span<const uint32_t> place_of_corner);

struct ClusterGroups {
  std::vector<uint32_t> members;
  std::vector<uint32_t> first{0};  // group g: members first[g] to first[g + 1]
  size_t count() const { return first.size() - 1; }
  std::span<const uint32_t> group(size_t g) const {
    return {members.data() + first[g], first[g + 1] - first[g]};
  }
};

// edges_of: of each cluster. Clusters that share no edge with another one are put together in their order.
ClusterGroups group_neighbours(std::span<const std::vector<OpenEdge>* const> edges_of);

}  // namespace fire3dv::scene
