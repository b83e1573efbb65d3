#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/glm.hpp>
#include <utility>

#include "renderer/scene/clusters/level_steps.h"

namespace fire3dv::scene {
namespace {

// Quadric error metrics: sums of squared distances to planes and of attribute differences (Garland and
// Heckbert 1997; Hoppe 1999). Double precision, since distances on finely tessellated smooth surfaces are a
// millionth of the coordinates.
struct Quadric {
  glm::dmat3 a{0};  // symmetric
  glm::dvec3 b{0};
  double c = 0, weight = 0;

  // Adds (dot(normal, p) + d)^2.
  void add_plane(const glm::dvec3& normal, double d, double plane_weight) {
    a += plane_weight * glm::outerProduct(normal, normal);
    b += plane_weight * d * normal;
    c += plane_weight * d * d;
    weight += plane_weight;
  }
  void add(const Quadric& other) {
    a += other.a;
    b += other.b;
    c += other.c;
    weight += other.weight;
  }
  double at(const glm::dvec3& p) const { return glm::dot(p, a * p) + 2 * glm::dot(b, p) + c; }
};

// Normal and texture coordinates, scaled to lengths of equal visual importance.
constexpr size_t kAttributeCount = 5;
using AttributeValues = std::array<double, kAttributeCount>;

struct AttributeQuadric {
  Quadric values;
  std::array<glm::dvec4, kAttributeCount> gradients{};
  double squares_weight = 0;

  void add_triangle(const std::array<glm::dvec3, 3>& p, const std::array<AttributeValues, 3>& s,
                    double weight) {
    const glm::dvec3 n = glm::cross(p[1] - p[0], p[2] - p[0]);
    const double n2 = glm::dot(n, n);
    if (!(n2 > 0)) return;
    const glm::dvec3 along[3] = {glm::cross(n, p[2] - p[1]) / n2, glm::cross(n, p[0] - p[2]) / n2,
                                 glm::cross(n, p[1] - p[0]) / n2};
    for (size_t k = 0; k < kAttributeCount; ++k) {
      const glm::dvec3 g = s[0][k] * along[0] + s[1][k] * along[1] + s[2][k] * along[2];
      const double d = s[0][k] - glm::dot(g, p[0]);
      values.add_plane(g, d, weight);
      gradients[k] += weight * glm::dvec4(g, d);
    }
    squares_weight += weight;
  }
  void add(const AttributeQuadric& other) {
    values.add(other.values);
    for (size_t k = 0; k < kAttributeCount; ++k) gradients[k] += other.gradients[k];
    squares_weight += other.squares_weight;
  }
  double at(const glm::dvec3& p, const AttributeValues& s) const {
    double sum = values.at(p);
    for (size_t k = 0; k < kAttributeCount; ++k) {
      sum += s[k] * (squares_weight * s[k] - 2 * (glm::dot(glm::dvec3(gradients[k]), p) + gradients[k].w));
    }
    return sum;
  }
};

// A level with more than this share of the finer level's triangles costs more than it saves.
constexpr double kWorthwhile = 0.85;
constexpr int kMaxPasses = 16;
// Tie-breaker of free collapses: the shortest edge first, which avoids needle triangles.
constexpr double kLengthShare = 1e-6;
// Minimum cosine between the normals of a triangle before and after a collapse.
constexpr double kLeastTurnCosine = 0.8;

using PatchCorners = std::array<uint32_t, 3>;

// Half-edge collapse simplifier over welded positions. Each pass collapses the cheapest edges onto one end;
// no collapse of a pass touches the neighbourhood of another one.
class Collapser {
 public:
  Collapser(const SurfacePatch& piece, std::span<const uint32_t> welded, const UsedAttributes& used)
      : piece_(piece) {
    number_welded(welded);
    for (size_t t = 0; t + 2 < piece.indices.size(); t += 3) {
      const PatchCorners vertices{piece.indices[t], piece.indices[t + 1], piece.indices[t + 2]};
      const PatchCorners corners{welded_[vertices[0]], welded_[vertices[1]], welded_[vertices[2]]};
      if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
      for (uint32_t p : corners) triangles_at_[p].push_back(static_cast<uint32_t>(vertices_.size()));
      vertices_.push_back(vertices);
      welded_corners_.push_back(corners);
    }
    only_vertex_.assign(points_.size(), kNone);
    for (uint32_t v = 0; v < welded_.size(); ++v) {
      only_vertex_[welded_[v]] = only_vertex_[welded_[v]] == kNone ? v : kSeveral;
    }
    touched_.assign(points_.size(), true);
    best_.resize(points_.size());
    lock_borders();
    weigh(used);
  }

  std::vector<uint32_t> collapse_to(size_t triangle_count) {
    size_t left = vertices_.size();
    for (int pass = 0; pass < kMaxPasses && left > triangle_count; ++pass) {
      const size_t before = left;
      left -= run_pass(left - triangle_count);
      if (left == before) break;
    }
    std::vector<uint32_t> out;
    for (size_t t = 0; t < vertices_.size(); ++t) {
      if (is_gone(welded_corners_[t])) continue;
      out.insert(out.end(), vertices_[t].begin(), vertices_[t].end());
    }
    return out;
  }

 private:
  struct Collapse {
    double cost;
    uint32_t from, to;
  };

  static constexpr uint32_t kSeveral = kNone - 1;

  static bool is_gone(const PatchCorners& c) { return c[0] == c[1]; }
  static bool has(const PatchCorners& c, uint32_t p) { return c[0] == p || c[1] == p || c[2] == p; }

  void number_welded(std::span<const uint32_t> welded) {
    std::vector<uint32_t> order(welded.size());
    for (uint32_t v = 0; v < order.size(); ++v) order[v] = v;
    std::sort(order.begin(), order.end(),
              [&](uint32_t a, uint32_t b) { return welded[a] != welded[b] ? welded[a] < welded[b] : a < b; });
    welded_.resize(welded.size());
    glm::dvec3 center(0);
    for (const glm::vec3& p : piece_.positions) center += glm::dvec3(p) / static_cast<double>(welded.size());
    for (size_t i = 0; i < order.size(); ++i) {
      if (i == 0 || welded[order[i]] != welded[order[i - 1]]) {
        points_.push_back(glm::dvec3(piece_.positions[order[i]]) - center);
      }
      welded_[order[i]] = static_cast<uint32_t>(points_.size() - 1);
    }
    triangles_at_.resize(points_.size());
  }

  // Locks ends of edges without exactly two triangles: borders and non-manifold edges.
  void lock_borders() {
    std::vector<uint64_t> edges;
    for (const PatchCorners& c : welded_corners_) {
      for (size_t i = 0; i < 3; ++i) {
        const uint32_t a = c[i], b = c[(i + 1) % 3];
        edges.push_back(uint64_t{std::min(a, b)} << 32 | std::max(a, b));
      }
    }
    std::sort(edges.begin(), edges.end());
    locked_.assign(points_.size(), false);
    for (size_t i = 0; i < edges.size();) {
      size_t end = i + 1;
      while (end < edges.size() && edges[end] == edges[i]) ++end;
      if (end - i != 2) locked_[edges[i] >> 32] = locked_[static_cast<uint32_t>(edges[i])] = true;
      i = end;
    }
  }

  void weigh(const UsedAttributes& used) {
    double area = 0, uv_area = 0;
    for (size_t t = 0; t < welded_corners_.size(); ++t) {
      area += glm::length(normal_of(welded_corners_[t]));
      const glm::dvec2 uv = piece_.attributes[vertices_[t][0]].uv0;
      const glm::dvec2 ab = glm::dvec2(piece_.attributes[vertices_[t][1]].uv0) - uv,
                       ac = glm::dvec2(piece_.attributes[vertices_[t][2]].uv0) - uv;
      uv_area += std::abs(ab.x * ac.y - ab.y * ac.x);
    }
    const double normal_m = used.normals && !welded_corners_.empty()
                                ? std::sqrt(area / static_cast<double>(welded_corners_.size()))
                                : 0;
    const double uv_m = used.uv0 && uv_area > 0 ? std::sqrt(area / uv_area) : 0;
    for (const VertexAttributes& at : piece_.attributes) {
      values_.push_back({normal_m * at.normal.x, normal_m * at.normal.y, normal_m * at.normal.z,
                         uv_m * at.uv0.x, uv_m * at.uv0.y});
    }
    quadrics_.resize(points_.size());
    attribute_quadrics_.resize(values_.size());
    for (size_t t = 0; t < welded_corners_.size(); ++t) {
      const PatchCorners& c = welded_corners_[t];
      const PatchCorners& v = vertices_[t];
      const glm::dvec3 n = normal_of(c);
      const double size = glm::length(n);
      if (!(size > 0)) continue;
      AttributeQuadric attributes;
      attributes.add_triangle({points_[c[0]], points_[c[1]], points_[c[2]]},
                              {values_[v[0]], values_[v[1]], values_[v[2]]}, size);
      for (size_t i = 0; i < 3; ++i) {
        quadrics_[c[i]].add_plane(n / size, -glm::dot(n, points_[c[0]]) / size, size);
        attribute_quadrics_[v[i]].add(attributes);
      }
    }
  }

  glm::dvec3 normal_of(const PatchCorners& c) const {
    return glm::cross(points_[c[1]] - points_[c[0]], points_[c[2]] - points_[c[0]]);
  }

  static uint32_t vertex_at(const PatchCorners& vertices, const PatchCorners& welded, uint32_t p) {
    return welded[0] == p ? vertices[0] : welded[1] == p ? vertices[1] : vertices[2];
  }

  // Maps each vertex at `from` to a vertex at `to`: the one on the same triangle of the edge, else (across a
  // seam) the one with the least attribute difference.
  void match_vertices(uint32_t from, uint32_t to) {
    matches_.clear();
    if (only_vertex_[from] != kSeveral && only_vertex_[to] != kSeveral) {
      matches_.emplace_back(only_vertex_[from], only_vertex_[to]);
      return;
    }
    auto known = [&](uint32_t vertex) {
      return std::any_of(matches_.begin(), matches_.end(), [&](const auto& m) { return m.first == vertex; });
    };
    for (uint32_t t : triangles_at_[from]) {
      if (is_gone(welded_corners_[t]) || !has(welded_corners_[t], to)) continue;
      const uint32_t vertex = vertex_at(vertices_[t], welded_corners_[t], from);
      if (!known(vertex)) matches_.emplace_back(vertex, vertex_at(vertices_[t], welded_corners_[t], to));
    }
    for (uint32_t t : triangles_at_[from]) {
      if (is_gone(welded_corners_[t])) continue;
      const uint32_t vertex = vertex_at(vertices_[t], welded_corners_[t], from);
      if (!known(vertex)) matches_.emplace_back(vertex, most_similar(vertex, to));
    }
  }

  uint32_t most_similar(uint32_t vertex, uint32_t to) const {
    uint32_t best = UINT32_MAX;
    double least = INFINITY;
    for (uint32_t t : triangles_at_[to]) {
      if (is_gone(welded_corners_[t])) continue;
      const uint32_t other = vertex_at(vertices_[t], welded_corners_[t], to);
      double difference = 0;
      for (size_t k = 0; k < kAttributeCount; ++k) {
        difference += (values_[other][k] - values_[vertex][k]) * (values_[other][k] - values_[vertex][k]);
      }
      if (difference < least || (difference == least && other < best)) {
        least = difference;
        best = other;
      }
    }
    return best;
  }

  double cost(uint32_t from, uint32_t to) {
    const glm::dvec3& p = points_[to];
    double sum = std::max(quadrics_[from].at(p), 0.0);
    auto add = [&](uint32_t vertex, uint32_t becomes) {
      sum += std::max(attribute_quadrics_[vertex].at(p, values_[becomes]), 0.0);
    };
    if (only_vertex_[from] != kSeveral && only_vertex_[to] != kSeveral) {
      add(only_vertex_[from], only_vertex_[to]);
    } else {
      match_vertices(from, to);
      for (const auto& [vertex, becomes] : matches_) add(vertex, becomes);
    }
    const glm::dvec3 edge = p - points_[from];
    return sum + kLengthShare * quadrics_[from].weight * glm::dot(edge, edge);
  }

  // True if the collapse keeps the surface manifold and inverts no triangle.
  bool is_allowed(uint32_t from, uint32_t to) {
    neighbours_of_to_.clear();
    for (uint32_t t : triangles_at_[to]) {
      if (is_gone(welded_corners_[t])) continue;
      for (uint32_t p : welded_corners_[t]) {
        if (p != to) neighbours_of_to_.push_back(p);
      }
    }
    std::sort(neighbours_of_to_.begin(), neighbours_of_to_.end());
    auto is_neighbour = [&](uint32_t p) {
      return std::binary_search(neighbours_of_to_.begin(), neighbours_of_to_.end(), p);
    };
    uint32_t of_edge = 0, twice_common = 0;
    for (uint32_t t : triangles_at_[from]) {
      const PatchCorners& c = welded_corners_[t];
      if (is_gone(c)) continue;
      for (uint32_t p : c) twice_common += p != from && p != to && is_neighbour(p) ? 1 : 0;
      if (has(c, to)) {
        ++of_edge;
        continue;
      }
      PatchCorners moved = c;
      for (uint32_t& p : moved) p = p == from ? to : p;
      const glm::dvec3 before = normal_of(c), after = normal_of(moved);
      const double size2 = glm::dot(before, before) * glm::dot(after, after);
      if (!(glm::dot(before, after) > kLeastTurnCosine * std::sqrt(size2))) return false;
    }
    // `from` is an interior position: each neighbour occurs in two triangles.
    return of_edge == 2 && twice_common == 4 && triangles_left(from) > 3;
  }

  size_t triangles_left(uint32_t p) const {
    return static_cast<size_t>(std::count_if(triangles_at_[p].begin(), triangles_at_[p].end(),
                                             [&](uint32_t t) { return !is_gone(welded_corners_[t]); }));
  }

  Collapse best_of(uint32_t from) {
    options_.clear();
    for (uint32_t t : triangles_at_[from]) {
      const PatchCorners& c = welded_corners_[t];
      if (is_gone(c)) continue;
      // Each neighbour follows `from` in exactly one triangle.
      const uint32_t to = c[0] == from ? c[1] : c[1] == from ? c[2] : c[0];
      options_.push_back({cost(from, to), from, to});
    }
    std::sort(options_.begin(), options_.end(), [](const Collapse& a, const Collapse& b) {
      return a.cost != b.cost ? a.cost < b.cost : a.to < b.to;
    });
    for (const Collapse& option : options_) {
      if (is_allowed(from, option.to)) return option;
    }
    return {INFINITY, from, from};
  }

  size_t run_pass(size_t wanted) {
    std::vector<Collapse> collapses;
    for (uint32_t from = 0; from < points_.size(); ++from) {
      if (locked_[from] || triangles_at_[from].empty()) continue;
      if (touched_[from]) best_[from] = best_of(from);
      if (best_[from].to != from) collapses.push_back(best_[from]);
    }
    std::sort(collapses.begin(), collapses.end(), [](const Collapse& a, const Collapse& b) {
      return a.cost != b.cost ? a.cost < b.cost : a.from < b.from;
    });
    // A collapse removes two triangles. Expensive ones wait, since the next pass may find cheaper ones.
    const size_t goal = std::max<size_t>(wanted / 2, 1);
    const double dearest = collapses.size() > goal ? 1.5 * collapses[goal - 1].cost : INFINITY;
    touched_.assign(points_.size(), false);
    size_t removed = 0;
    for (const Collapse& c : collapses) {
      if (removed >= wanted || c.cost > dearest) break;
      if (touched_[c.from] || touched_[c.to]) continue;
      removed += collapse(c.from, c.to);
    }
    return removed;
  }

  size_t collapse(uint32_t from, uint32_t to) {
    match_vertices(from, to);
    size_t removed = 0;
    touch_around(from);
    touch_around(to);
    for (uint32_t t : triangles_at_[from]) {
      PatchCorners& c = welded_corners_[t];
      if (is_gone(c)) continue;
      if (has(c, to)) {
        c = {0, 0, 0};
        ++removed;
        continue;
      }
      for (size_t i = 0; i < 3; ++i) {
        if (c[i] != from) continue;
        c[i] = to;
        const auto match = std::find_if(matches_.begin(), matches_.end(),
                                        [&](const auto& m) { return m.first == vertices_[t][i]; });
        vertices_[t][i] = match->second;
      }
      triangles_at_[to].push_back(t);
    }
    triangles_at_[from].clear();
    std::erase_if(triangles_at_[to], [&](uint32_t t) { return is_gone(welded_corners_[t]); });
    quadrics_[to].add(quadrics_[from]);
    for (const auto& [vertex, becomes] : matches_)
      attribute_quadrics_[becomes].add(attribute_quadrics_[vertex]);
    return removed;
  }

  // Collapse costs depend on neighbours, so they are invalidated, too.
  void touch_around(uint32_t welded) {
    for (uint32_t t : triangles_at_[welded]) {
      if (is_gone(welded_corners_[t])) continue;
      for (uint32_t p : welded_corners_[t]) touched_[p] = true;
    }
  }

  const SurfacePatch& piece_;
  std::vector<uint32_t> welded_;                         // welded position of each vertex of the piece
  std::vector<glm::dvec3> points_;                       // per position, relative to the centre
  std::vector<PatchCorners> vertices_, welded_corners_;  // per triangle
  std::vector<std::vector<uint32_t>> triangles_at_;      // per position
  std::vector<uint32_t> only_vertex_;                    // per position
  std::vector<bool> locked_;
  std::vector<bool> touched_;  // changed in the last pass: costs are out of date
  std::vector<Collapse> best_, options_;
  std::vector<AttributeValues> values_;  // per vertex
  std::vector<Quadric> quadrics_;
  std::vector<AttributeQuadric> attribute_quadrics_;
  std::vector<std::pair<uint32_t, uint32_t>> matches_;
  std::vector<uint32_t> neighbours_of_to_;
};

}  // namespace

std::vector<uint32_t> simplify_to_half(const SurfacePatch& piece, std::span<const uint32_t> welded,
                                       const UsedAttributes& used) {
  const size_t count = piece.indices.size() / 3;
  std::vector<uint32_t> out = Collapser(piece, welded, used).collapse_to(count / 2);
  if (static_cast<double>(out.size()) > kWorthwhile * static_cast<double>(piece.indices.size())) out.clear();
  return out;
}

}  // namespace fire3dv::scene
