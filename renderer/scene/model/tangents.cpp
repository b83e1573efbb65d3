#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <numeric>
#include <span>
#include <tuple>
#include <vector>

#include "renderer/scene/model/scene.h"
#include "renderer/scene/model/vertices.h"

namespace fire3dv::scene {
namespace {

// Texture-space frame of a triangle.
struct TriangleFrame {
  glm::vec3 rising_u{0};   // unit direction of increasing u
  bool mirrored = false;   // texture-space winding is opposite to the triangle's
  bool undecided = false;  // zero area in texture space: takes the winding of its neighbours
  bool collapsed = false;  // two equal corners: belongs to no group
};

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

// Groups the corners that share a tangent frame, as MikkTSpace defines it. Group of each corner, or kNone;
// groups are numbered in order of their first corner. `vertex_of_corner` is welded. Sets the winding of
// undecided triangles.
std::vector<uint32_t> tangent_groups(std::span<const uint32_t> vertex_of_corner,
                                     std::span<TriangleFrame> frames) {
  return Grouping(vertex_of_corner, frames).run();
}

constexpr float kSmallest = std::numeric_limits<float>::min();

glm::vec3 normalized_or(const glm::vec3& vector, const glm::vec3& otherwise) {
  const float length = std::sqrt(glm::dot(vector, vector));
  return length > 1e-20f && std::isfinite(length) ? vector / length : otherwise;
}

glm::vec3 in_surface(const glm::vec3& vector, const glm::vec3& normal) {
  return normalized_or(vector - normal * glm::dot(normal, vector), glm::vec3(0));
}

// Arbitrary tangent for vertices whose texture coordinates define none.
glm::vec4 any_tangent(const glm::vec3& normal) {
  const glm::vec3 axis = std::abs(normal.x) < 0.9f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
  return glm::vec4(normalized_or(axis - normal * glm::dot(axis, normal), glm::vec3(1, 0, 0)), 1);
}

class TangentFrames {
 public:
  TangentFrames(const Vertices& vertices, std::span<const uint32_t> indices, uint32_t uv_set)
      : vertices_(vertices), uv_set_(uv_set) {
    const std::vector<uint32_t> welded_vertex = weld();
    corner_vertex_.reserve(indices.size());
    for (const uint32_t vertex : indices) corner_vertex_.push_back(welded_vertex[vertex]);
    frames_.reserve(indices.size() / 3);
    for (size_t first = 0; first < indices.size(); first += 3) frames_.push_back(frame_of(first));
    group_ = tangent_groups(corner_vertex_, frames_);
    average_groups();
    group_lone_corners();
  }

  glm::vec4 of_corner(size_t corner) const {
    if (group_[corner] == kNone) return any_tangent(normal(corner));
    return tangents_[group_[corner]];
  }

 private:
  const glm::vec3& position(size_t corner) const { return vertices_.positions[corner_vertex_[corner]]; }
  const glm::vec3& normal(size_t corner) const { return vertices_.attributes[corner_vertex_[corner]].normal; }
  const glm::vec2& uv(uint32_t vertex) const {
    const VertexAttributes& attributes = vertices_.attributes[vertex];
    return uv_set_ == 0 ? attributes.uv0 : attributes.uv1;
  }

  using Key = std::array<float, 8>;
  Key key_of(uint32_t v) const {
    const glm::vec3 &p = vertices_.positions[v], &n = vertices_.attributes[v].normal;
    const glm::vec2& t = uv(v);
    return {p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y};
  }
  // Hash of a key; equal keys have equal hashes.
  static uint64_t mixed(const Key& key) {
    uint64_t mix = 0;
    for (const float value : key)
      mix = (mix ^ std::bit_cast<uint32_t>(value + 0.0f)) * 0x9e3779b97f4a7c15u;  // -0 equals 0
    return mix ^ mix >> 32;
  }

  // First equal vertex of each vertex (position, normal, texture coordinates). Sorted by hash, then by key:
  // hostile collisions do not degrade it.
  std::vector<uint32_t> weld() const {
    struct Mixed {
      uint64_t mix;
      uint32_t vertex;
      bool operator<(const Mixed& other) const {
        return mix != other.mix ? mix < other.mix : vertex < other.vertex;
      }
    };
    std::vector<Mixed> order;
    order.reserve(vertices_.positions.size());
    for (uint32_t v = 0; v < vertices_.positions.size(); ++v) order.push_back({mixed(key_of(v)), v});
    std::sort(order.begin(), order.end());
    std::vector<uint32_t> welded(order.size());
    for (auto first = order.begin(); first != order.end();) {
      const auto end = std::find_if(first, order.end(), [&](const Mixed& m) { return m.mix != first->mix; });
      const Key key = key_of(first->vertex);
      if (!std::all_of(first, end, [&](const Mixed& m) { return key_of(m.vertex) == key; })) {
        std::sort(first, end, [&](const Mixed& a, const Mixed& b) {
          return std::tuple(key_of(a.vertex), a.vertex) < std::tuple(key_of(b.vertex), b.vertex);
        });
      }
      for (auto m = first; m != end; ++m) {
        const bool same = m != first && key_of(m->vertex) == key_of((m - 1)->vertex);
        welded[m->vertex] = same ? welded[(m - 1)->vertex] : m->vertex;
      }
      first = end;
    }
    return welded;
  }

  TriangleFrame frame_of(size_t first) const {
    const glm::vec3 &p0 = position(first), &p1 = position(first + 1), &p2 = position(first + 2);
    TriangleFrame frame;
    frame.collapsed = p0 == p1 || p1 == p2 || p2 == p0;
    const glm::vec3 edge1 = p1 - p0, edge2 = p2 - p0;
    // glTF's v points down in the image; the tangent frame's v points up.
    const glm::vec2 origin = uv(corner_vertex_[first]);
    const glm::vec2 uv1 = (uv(corner_vertex_[first + 1]) - origin) * glm::vec2(1, -1);
    const glm::vec2 uv2 = (uv(corner_vertex_[first + 2]) - origin) * glm::vec2(1, -1);
    const float area = uv1.x * uv2.y - uv1.y * uv2.x;
    frame.mirrored = area < 0;
    frame.rising_u = normalized_or((edge1 * uv2.y - edge2 * uv1.y) * (area < 0 ? -1.0f : 1.0f), glm::vec3(0));
    const glm::vec3 rising_v = normalized_or(edge2 * uv1.x - edge1 * uv2.x, glm::vec3(0));
    frame.undecided =
        !(std::abs(area) > kSmallest) || frame.rising_u == glm::vec3(0) || rising_v == glm::vec3(0);
    return frame;
  }

  // Angle between the edges at a corner, projected to the tangent plane.
  float angle_at(size_t corner) const {
    const size_t first = corner / 3 * 3;
    const glm::vec3& here = position(corner);
    const glm::vec3 to_next = in_surface(position(first + (corner + 1) % 3) - here, normal(corner));
    const glm::vec3 to_previous = in_surface(position(first + (corner + 2) % 3) - here, normal(corner));
    return std::acos(std::clamp(glm::dot(to_next, to_previous), -1.0f, 1.0f));
  }

  void average_groups() {
    struct Sum {
      glm::vec3 tangent{0};
      uint32_t last_corner = 0;
    };
    std::vector<Sum> sums;
    for (uint32_t corner = 0; corner < group_.size(); ++corner) {
      if (group_[corner] == kNone) continue;
      if (group_[corner] >= sums.size()) sums.resize(size_t{group_[corner]} + 1);
      Sum& sum = sums[group_[corner]];
      sum.last_corner = corner;
      const TriangleFrame& frame = frames_[corner / 3];
      if (!frame.undecided) sum.tangent += angle_at(corner) * in_surface(frame.rising_u, normal(corner));
    }
    tangents_.reserve(sums.size());
    for (const Sum& sum : sums) {
      const glm::vec3 otherwise(any_tangent(normal(sum.last_corner)));
      const bool mirrored = frames_[sum.last_corner / 3].mirrored;
      tangents_.emplace_back(normalized_or(sum.tangent, otherwise), mirrored ? -1.0f : 1.0f);
    }
  }

  // Ungrouped corners (degenerate triangles) take the group of another corner at their vertex.
  void group_lone_corners() {
    std::vector<uint32_t> group_of_vertex(vertices_.positions.size(), kNone);
    for (size_t corner = group_.size(); corner-- > 0;) {
      if (group_[corner] != kNone) group_of_vertex[corner_vertex_[corner]] = group_[corner];
    }
    for (size_t corner = 0; corner < group_.size(); ++corner) {
      if (group_[corner] == kNone) group_[corner] = group_of_vertex[corner_vertex_[corner]];
    }
  }

  const Vertices& vertices_;
  uint32_t uv_set_;
  std::vector<uint32_t> corner_vertex_;  // welded
  std::vector<TriangleFrame> frames_;
  std::vector<uint32_t> group_;      // per corner
  std::vector<glm::vec4> tangents_;  // per group
};

// A corner whose vertex already has another tangent.
struct SplitCorner {
  uint32_t vertex;
  glm::vec4 tangent;
  uint32_t corner;
  auto key() const { return std::tuple(vertex, tangent.x, tangent.y, tangent.z, tangent.w); }
};

}  // namespace

void generate_tangents(Vertices& vertices, std::span<uint32_t> indices, uint32_t uv_set) {
  const auto vertex_count = static_cast<uint32_t>(vertices.positions.size());
  std::vector<SplitCorner> splits;
  {
    const TangentFrames frames(vertices, indices, uv_set);
    std::vector<bool> has_tangent(vertex_count, false);
    for (VertexAttributes& vertex : vertices.attributes) vertex.tangent = any_tangent(vertex.normal);
    for (uint32_t corner = 0; corner < indices.size(); ++corner) {
      const uint32_t vertex = indices[corner];
      const glm::vec4 tangent = frames.of_corner(corner);
      if (!has_tangent[vertex]) vertices.attributes[vertex].tangent = tangent;
      has_tangent[vertex] = true;
      if (vertices.attributes[vertex].tangent != tangent) splits.push_back({vertex, tangent, corner});
    }
  }
  if (splits.empty()) return;
  std::sort(splits.begin(), splits.end(), [](const SplitCorner& a, const SplitCorner& b) {
    return std::tuple(a.key(), a.corner) < std::tuple(b.key(), b.corner);
  });
  std::vector<uint32_t> copied(vertex_count);
  std::iota(copied.begin(), copied.end(), 0u);
  for (size_t i = 0; i < splits.size(); ++i) {
    if (i == 0 || splits[i].key() != splits[i - 1].key()) copied.push_back(splits[i].vertex);
    indices[splits[i].corner] = static_cast<uint32_t>(copied.size() - 1);
  }
  copy_vertices(vertices, copied);
  for (const SplitCorner& split : splits) vertices.attributes[indices[split.corner]].tangent = split.tangent;
}

}  // namespace fire3dv::scene
