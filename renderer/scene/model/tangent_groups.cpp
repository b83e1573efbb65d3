#include "renderer/scene/model/tangent_groups.h"

#include <algorithm>

#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {
namespace {

// A corner index also denotes the edge from it to the next corner of its triangle.
uint32_t next_corner(uint32_t corner) {
  return corner % 3 == 2 ? corner - 2 : corner + 1;
}
uint32_t previous_corner(uint32_t corner) {
  return corner % 3 == 0 ? corner + 2 : corner - 1;
}

// Opposite half-edge of each edge, or kNone. At non-manifold edges, half-edges are paired in order.
std::vector<uint32_t> opposite_edges(std::span<const uint32_t> vertex_of_corner,
                                     std::span<const TriangleFrame> frames) {
  struct Edge {
    uint32_t low, high, corner;
    bool operator<(const Edge& other) const {
      return high != other.high ? high < other.high : corner < other.corner;
    }
  };
  // Counting sort by lower vertex, then a sort within each vertex.
  const uint32_t vertex_count =
      vertex_of_corner.empty() ? 0 : *std::max_element(vertex_of_corner.begin(), vertex_of_corner.end()) + 1;
  const auto ends = [&](uint32_t corner) {
    return std::minmax(vertex_of_corner[corner], vertex_of_corner[next_corner(corner)]);
  };
  std::vector<uint32_t> first_of_vertex(size_t{vertex_count} + 1, 0);
  for (uint32_t corner = 0; corner < vertex_of_corner.size(); ++corner) {
    if (!frames[corner / 3].collapsed) ++first_of_vertex[ends(corner).first + 1];
  }
  for (size_t v = 0; v < vertex_count; ++v) first_of_vertex[v + 1] += first_of_vertex[v];
  std::vector<Edge> edges(first_of_vertex.back());
  std::vector<uint32_t> next(first_of_vertex.begin(), first_of_vertex.end() - 1);
  for (uint32_t corner = 0; corner < vertex_of_corner.size(); ++corner) {
    if (frames[corner / 3].collapsed) continue;
    const auto [low, high] = ends(corner);
    edges[next[low]++] = {low, high, corner};
  }
  for (size_t v = 0; v < vertex_count; ++v)
    std::sort(edges.begin() + first_of_vertex[v], edges.begin() + first_of_vertex[v + 1]);

  std::vector<uint32_t> opposite(vertex_of_corner.size(), kNone);
  const auto rises = [&](const Edge& edge) { return vertex_of_corner[edge.corner] == edge.low; };
  for (size_t first = 0; first < edges.size();) {
    // Unpaired edges between the same vertices; all have the same direction.
    size_t waiting = first, end = first;
    for (; end < edges.size() && edges[end].low == edges[first].low && edges[end].high == edges[first].high;
         ++end) {
      while (waiting < end && opposite[edges[waiting].corner] != kNone) ++waiting;
      if (waiting == end || rises(edges[waiting]) == rises(edges[end])) continue;
      opposite[edges[waiting].corner] = edges[end].corner;
      opposite[edges[end].corner] = edges[waiting].corner;
    }
    first = end;
  }
  return opposite;
}

class Grouping {
 public:
  Grouping(std::span<const uint32_t> vertex_of_corner, std::span<TriangleFrame> frames)
      : opposite_(opposite_edges(vertex_of_corner, frames)),
        frames_(frames),
        group_of_corner_(vertex_of_corner.size(), kNone) {}

  std::vector<uint32_t> run() {
    uint32_t groups = 0;
    for (uint32_t corner = 0; corner < group_of_corner_.size(); ++corner) {
      const TriangleFrame& frame = frames_[corner / 3];
      if (frame.undecided || frame.collapsed || group_of_corner_[corner] != kNone) continue;
      fill(corner, groups++, frame.mirrored);
    }
    return std::move(group_of_corner_);
  }

 private:
  // Flood fill around one vertex over triangles of equal winding in texture space.
  void fill(uint32_t start, uint32_t group, bool mirrored) {
    pending_.assign(1, start);
    while (!pending_.empty()) {
      const uint32_t corner = pending_.back();
      pending_.pop_back();
      if (group_of_corner_[corner] != kNone || !takes(corner / 3, mirrored)) continue;
      group_of_corner_[corner] = group;
      // The same vertex in the triangles across the incoming and the outgoing edge.
      if (const uint32_t in = opposite_[previous_corner(corner)]; in != kNone) pending_.push_back(in);
      if (const uint32_t out = opposite_[corner]; out != kNone) pending_.push_back(next_corner(out));
    }
  }

  bool takes(uint32_t triangle, bool mirrored) {
    TriangleFrame& frame = frames_[triangle];
    const uint32_t* groups = &group_of_corner_[size_t{triangle} * 3];
    // The first group that reaches an undecided triangle sets its winding.
    if (frame.undecided && groups[0] == kNone && groups[1] == kNone && groups[2] == kNone)
      frame.mirrored = mirrored;
    return frame.mirrored == mirrored;
  }

  std::vector<uint32_t> opposite_;
  std::span<TriangleFrame> frames_;
  std::vector<uint32_t> group_of_corner_;
  std::vector<uint32_t> pending_;
};

}  // namespace

std::vector<uint32_t> tangent_groups(std::span<const uint32_t> vertex_of_corner,
                                     std::span<TriangleFrame> frames) {
  return Grouping(vertex_of_corner, frames).run();
}

}  // namespace fire3dv::scene
