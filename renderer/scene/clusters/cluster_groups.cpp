#include "renderer/scene/clusters/level_steps.h"

#include <algorithm>
#include <utility>

namespace fire3dv::scene {
namespace {

// Target group size. Larger groups lock a smaller share of edges; smaller groups make LOD transitions less
// visible.
constexpr size_t kGroupClusters = 16;
// Smaller groups are merged into a neighbour.
constexpr size_t kSmallGroup = 6;
constexpr size_t kMaxClusters = 24;
// Edges of more clusters than this are ignored for adjacency.
constexpr size_t kMaxAtEdge = 6;
constexpr uint32_t kNoGroup = UINT32_MAX;

struct Neighbours {
  struct Neighbour {
    uint32_t cluster, shared_edges;
  };
  std::vector<Neighbour> all;
  std::vector<uint32_t> first;
  std::span<const Neighbour> of(uint32_t cluster) const {
    return {all.data() + first[cluster], first[cluster + 1] - first[cluster]};
  }
};

Neighbours find_neighbours(std::span<const std::vector<OpenEdge>* const> edges_of) {
  std::vector<std::pair<OpenEdge, uint32_t>> users;
  size_t count = 0;
  for (const std::vector<OpenEdge>* edges : edges_of) count += edges->size();
  users.reserve(count);
  for (uint32_t c = 0; c < edges_of.size(); ++c) {
    for (OpenEdge edge : *edges_of[c]) users.emplace_back(edge, c);
  }
  std::sort(users.begin(), users.end());
  std::vector<uint64_t> pairs;
  pairs.reserve(count);
  for (size_t i = 0; i < users.size();) {
    size_t end = i + 1;
    while (end < users.size() && users[end].first == users[i].first) ++end;
    for (size_t a = i; end - i <= kMaxAtEdge && a < end; ++a) {
      for (size_t b = i; b < end; ++b) {
        if (users[a].second != users[b].second)
          pairs.push_back(uint64_t{users[a].second} << 32 | users[b].second);
      }
    }
    i = end;
  }
  std::sort(pairs.begin(), pairs.end());
  Neighbours neighbours;
  neighbours.first.assign(edges_of.size() + 1, 0);
  for (size_t i = 0; i < pairs.size();) {
    size_t end = i + 1;
    while (end < pairs.size() && pairs[end] == pairs[i]) ++end;
    neighbours.all.push_back({static_cast<uint32_t>(pairs[i]), static_cast<uint32_t>(end - i)});
    ++neighbours.first[(pairs[i] >> 32) + 1];
    i = end;
  }
  for (size_t c = 0; c < edges_of.size(); ++c) neighbours.first[c + 1] += neighbours.first[c];
  return neighbours;
}

// Greedy growth of groups: each step adds the cluster with the largest shared border.
class Grower {
 public:
  Grower(const Neighbours& neighbours, size_t count) : neighbours_(neighbours), group_of_(count, kNoGroup) {}

  std::vector<std::vector<uint32_t>> grow() {
    for (uint32_t seed = 0; seed < group_of_.size(); ++seed) {
      if (group_of_[seed] != kNoGroup) continue;
      grow_from(seed);
    }
    join_small_ones();
    return std::move(groups_);
  }

 private:
  void take(uint32_t cluster) {
    const auto group = static_cast<uint32_t>(groups_.size() - 1);
    group_of_[cluster] = group;
    groups_.back().push_back(cluster);
    std::erase_if(candidates_, [&](const auto& candidate) { return candidate.cluster == cluster; });
    for (const Neighbours::Neighbour& next : neighbours_.of(cluster)) {
      if (group_of_[next.cluster] != kNoGroup) continue;
      auto known = std::find_if(candidates_.begin(), candidates_.end(),
                                [&](const auto& candidate) { return candidate.cluster == next.cluster; });
      if (known == candidates_.end()) {
        candidates_.push_back(next);
      } else {
        known->shared_edges += next.shared_edges;
      }
    }
  }

  void grow_from(uint32_t seed) {
    groups_.emplace_back();
    candidates_.clear();
    take(seed);
    while (groups_.back().size() < kGroupClusters && !candidates_.empty()) {
      const auto best =
          std::max_element(candidates_.begin(), candidates_.end(), [](const auto& a, const auto& b) {
            return a.shared_edges != b.shared_edges ? a.shared_edges < b.shared_edges : a.cluster > b.cluster;
          });
      take(best->cluster);
    }
  }

  void join_small_ones() {
    for (uint32_t g = 0; g < groups_.size(); ++g) {
      if (groups_[g].size() >= kSmallGroup) continue;
      std::vector<std::pair<uint32_t, uint32_t>> shared;  // group, number of edges
      for (uint32_t cluster : groups_[g]) {
        for (const Neighbours::Neighbour& next : neighbours_.of(cluster)) {
          const uint32_t other = group_of_[next.cluster];
          if (other == g || groups_[other].size() + groups_[g].size() > kMaxClusters) continue;
          auto known =
              std::find_if(shared.begin(), shared.end(), [&](const auto& s) { return s.first == other; });
          if (known == shared.end()) known = shared.insert(shared.end(), {other, 0});
          known->second += next.shared_edges;
        }
      }
      if (shared.empty()) continue;
      const uint32_t into = std::max_element(shared.begin(), shared.end(), [](const auto& a, const auto& b) {
                              return a.second != b.second ? a.second < b.second : a.first > b.first;
                            })->first;
      for (uint32_t cluster : groups_[g]) {
        group_of_[cluster] = into;
        groups_[into].push_back(cluster);
      }
      groups_[g].clear();
    }
  }

  const Neighbours& neighbours_;
  std::vector<uint32_t> group_of_;
  std::vector<Neighbours::Neighbour> candidates_;
  std::vector<std::vector<uint32_t>> groups_;
};

}  // namespace

std::vector<OpenEdge> open_edges(std::span<const uint32_t> place_of_corner) {
  std::vector<OpenEdge> edges;
  edges.reserve(place_of_corner.size());
  for (size_t corner = 0; corner < place_of_corner.size(); ++corner) {
    const uint32_t a = place_of_corner[corner],
                   b = place_of_corner[corner % 3 == 2 ? corner - 2 : corner + 1];
    if (a != b) edges.push_back(uint64_t{std::min(a, b)} << 32 | std::max(a, b));
  }
  std::sort(edges.begin(), edges.end());
  size_t count = 0;
  for (size_t i = 0; i < edges.size();) {
    size_t end = i + 1;
    while (end < edges.size() && edges[end] == edges[i]) ++end;
    if (end - i == 1) edges[count++] = edges[i];
    i = end;
  }
  edges.resize(count);
  edges.shrink_to_fit();
  return edges;
}

ClusterGroups group_neighbours(std::span<const std::vector<OpenEdge>* const> edges_of) {
  const Neighbours neighbours = find_neighbours(edges_of);
  const std::vector<std::vector<uint32_t>> grown = Grower(neighbours, edges_of.size()).grow();
  ClusterGroups groups;
  std::vector<uint32_t> small;  // no neighbour has room for them
  auto end_group = [&] { groups.first.push_back(static_cast<uint32_t>(groups.members.size())); };
  for (const std::vector<uint32_t>& group : grown) {
    if (group.empty()) continue;
    if (group.size() < kSmallGroup) {
      if (small.size() + group.size() > kGroupClusters) {
        groups.members.insert(groups.members.end(), small.begin(), small.end());
        end_group();
        small.clear();
      }
      small.insert(small.end(), group.begin(), group.end());
      continue;
    }
    groups.members.insert(groups.members.end(), group.begin(), group.end());
    end_group();
  }
  groups.members.insert(groups.members.end(), small.begin(), small.end());
  if (!small.empty()) end_group();
  return groups;
}

}  // namespace fire3dv::scene
