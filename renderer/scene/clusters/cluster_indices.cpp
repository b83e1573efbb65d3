#include "renderer/scene/clusters/cluster_indices.h"

#include <algorithm>

#include "protocol/base/parallel.h"

namespace fire3dv::scene {

uint64_t index_count(const ClusteredGeometry& geometry) {
  uint64_t end = 0;
  for (const ClusteredPrimitive& p : geometry.primitives)
    end = std::max(end, uint64_t{p.first_index} + p.index_count);
  return end;
}

ClusterIndices::ClusterIndices(const Scene& scene, const ClusteredGeometry& geometry) {
  for (size_t i = 0; i < scene.primitives.size(); ++i) {
    const ClusteredPrimitive& primitive = geometry.primitives[i];
    const Primitive& source = scene.primitives[i];
    if (source.topology != Topology::triangles) {
      runs_.push_back({primitive.first_index, primitive.index_count, nullptr,
                       scene.indices.data() + source.first_index, 0});
      continue;
    }
    uint32_t next = primitive.first_index;
    for (const Cluster& cluster :
         std::span(geometry.clusters).subspan(primitive.first_cluster, primitive.cluster_count)) {
      runs_.push_back({next, 3 * cluster.triangle_count, geometry.triangles.data() + cluster.first_triangle,
                       nullptr, cluster.first_vertex - primitive.first_vertex});
      next += 3 * cluster.triangle_count;
    }
  }
}

void ClusterIndices::write(uint64_t first, std::span<uint32_t> to) const {
  constexpr size_t kTurn = 64;
  parallel_for((runs_.size() + kTurn - 1) / kTurn, [&](size_t turn) {
    for (size_t r = turn * kTurn; r < std::min(runs_.size(), (turn + 1) * kTurn); ++r)
      write(runs_[r], first, to);
  });
}

void ClusterIndices::write(const Run& run, uint64_t first, std::span<uint32_t> to) {
  const uint64_t begin = std::max<uint64_t>(run.first_index, first);
  const uint64_t end = std::min<uint64_t>(uint64_t{run.first_index} + run.index_count, first + to.size());
  if (!run.triangles) {
    for (uint64_t i = begin; i < end; ++i) to[i - first] = run.indices[i - run.first_index];
    return;
  }
  const auto corner = [&](uint64_t i) {
    const uint64_t own = i - run.first_index;
    return run.first_vertex + (run.triangles[own / 3] >> (8 * (own % 3)) & 0xff);
  };
  uint64_t i = begin;
  for (; i < end && (i - run.first_index) % 3 != 0; ++i) to[i - first] = corner(i);
  for (; i + 3 <= end; i += 3) {  // whole triangles
    const uint32_t packed = run.triangles[(i - run.first_index) / 3];
    uint32_t* const written = &to[i - first];
    written[0] = run.first_vertex + (packed & 0xff);
    written[1] = run.first_vertex + (packed >> 8 & 0xff);
    written[2] = run.first_vertex + (packed >> 16 & 0xff);
  }
  for (; i < end; ++i) to[i - first] = corner(i);
}

}  // namespace fire3dv::scene
