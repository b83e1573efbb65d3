#include "renderer/scene/derived/loaded_scene.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>
#include <span>

#include "base/parallel.h"

namespace fire3dv::scene {
namespace {

// Hash map from positions to indices in order of first occurrence. The random seed prevents files from
// choosing colliding positions.
class PointNumbers {
 public:
  explicit PointNumbers(size_t most)
      : slots_(std::bit_ceil(2 * most + 1), kNone), seed_(std::random_device{}()) {}

  uint32_t number_of(const glm::vec3& position, std::vector<glm::vec3>& points) {
    size_t slot = hash(position) & (slots_.size() - 1);
    for (; slots_[slot] != kNone; slot = (slot + 1) & (slots_.size() - 1)) {
      if (std::memcmp(&points[slots_[slot]], &position, sizeof(position)) == 0) return slots_[slot];
    }
    slots_[slot] = static_cast<uint32_t>(points.size());
    points.push_back(position);
    return slots_[slot];
  }

 private:
  size_t hash(const glm::vec3& p) const {
    uint64_t mixed = seed_;
    for (int c = 0; c < 3; ++c) {
      mixed = (mixed ^ std::bit_cast<uint32_t>(p[c])) * 0x9e3779b97f4a7c15u;
      mixed ^= mixed >> 32;
    }
    return mixed;
  }

  std::vector<uint32_t> slots_;
  uint64_t seed_;
};

struct WeldedTriangles {
  std::vector<glm::vec3> points;
  std::vector<uint32_t> corners;  // three per triangle; degenerate triangles are omitted
};

WeldedTriangles weld(const Scene& scene, const Mesh& mesh) {
  WeldedTriangles welded;
  size_t vertices = 0;
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    vertices += scene.primitives[p].vertex_count;
  }
  PointNumbers numbers(vertices);
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    const Primitive& primitive = scene.primitives[p];
    if (primitive.topology != Topology::triangles) continue;
    std::vector<uint32_t> point_of_vertex(primitive.vertex_count);
    for (uint32_t v = 0; v < primitive.vertex_count; ++v) {
      const glm::vec3 position = scene.positions[primitive.first_vertex + v] + 0.0f;  // -0 becomes 0
      point_of_vertex[v] = numbers.number_of(position, welded.points);
    }
    for (uint32_t i = 0; i + 2 < primitive.index_count; i += 3) {
      const uint32_t* index = scene.indices.data() + primitive.first_index + i;
      const uint32_t a = point_of_vertex[index[0]], b = point_of_vertex[index[1]],
                     c = point_of_vertex[index[2]];
      if (a != b && b != c && c != a) welded.corners.insert(welded.corners.end(), {a, b, c});
    }
  }
  return welded;
}

// Connected components by union-find: component of each point.
std::vector<uint32_t> connected_components(const WeldedTriangles& mesh) {
  std::vector<uint32_t> towards(mesh.points.size());
  std::iota(towards.begin(), towards.end(), 0u);
  auto piece_of = [&](uint32_t point) {
    while (towards[point] != point) point = towards[point] = towards[towards[point]];
    return point;
  };
  for (size_t i = 0; i < mesh.corners.size(); i += 3) {
    for (int c = 1; c < 3; ++c)
      towards[piece_of(mesh.corners[i])] = piece_of(mesh.corners[i + static_cast<size_t>(c)]);
  }
  for (uint32_t point = 0; point < towards.size(); ++point) towards[point] = piece_of(point);
  return towards;
}

// Vertices of unpaired edges; an edge is paired if it occurs once in each direction. Empty for a closed mesh.
std::vector<uint32_t> border_points(const WeldedTriangles& mesh) {
  // Counting sort of edges by lower vertex: edges of a point are first_of[point] .. first_of[point + 1].
  std::vector<uint32_t> first_of(mesh.points.size() + 1, 0);
  const auto for_each_edge = [&](const auto& visit) {
    for (size_t i = 0; i < mesh.corners.size(); ++i) {
      const uint32_t from = mesh.corners[i], to = mesh.corners[i % 3 == 2 ? i - 2 : i + 1];
      visit(std::min(from, to), std::max(from, to), from > to);
    }
  };
  for_each_edge([&](uint32_t lower, uint32_t, bool) { ++first_of[lower + 1]; });
  std::partial_sum(first_of.begin(), first_of.end(), first_of.begin());
  std::vector<uint64_t> edges(mesh.corners.size());  // upper vertex and direction
  std::vector<uint32_t> next(first_of.begin(), first_of.end() - 1);
  for_each_edge([&](uint32_t lower, uint32_t upper, bool backwards) {
    edges[next[lower]++] = uint64_t{upper} << 1 | (backwards ? 1 : 0);
  });
  std::vector<uint32_t> borders;
  for (uint32_t point = 0; point < mesh.points.size(); ++point) {
    const std::span<uint64_t> own(edges.data() + first_of[point], edges.data() + first_of[point + 1]);
    std::sort(own.begin(), own.end());
    for (size_t e = 0; e < own.size();) {
      const bool paired = own[e] % 2 == 0 && e + 1 < own.size() && own[e + 1] == own[e] + 1 &&
                          (e + 2 == own.size() || own[e + 2] >> 1 != own[e] >> 1);
      if (!paired) borders.insert(borders.end(), {point, static_cast<uint32_t>(own[e] >> 1)});
      e += paired ? 2 : 1;
    }
  }
  std::sort(borders.begin(), borders.end());
  borders.erase(std::unique(borders.begin(), borders.end()), borders.end());
  return borders;
}

// Welds border vertices separated by rounding, for example at the seam of a revolved mesh (sin(2 pi) is not
// 0). Such gaps are far narrower than a shadow map texel.
void weld_borders(WeldedTriangles& mesh, std::vector<uint32_t> borders) {
  glm::vec3 low = mesh.points[0], high = low;
  for (const glm::vec3& p : mesh.points) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const float reach = 2e-6f * glm::length(high - low);
  std::sort(borders.begin(), borders.end(), [&](uint32_t a, uint32_t b) {
    return mesh.points[a].x != mesh.points[b].x ? mesh.points[a].x < mesh.points[b].x : a < b;
  });
  std::vector<uint32_t> same(mesh.points.size());
  std::iota(same.begin(), same.end(), 0u);
  for (size_t i = 0; i < borders.size(); ++i) {
    if (same[borders[i]] != borders[i]) continue;
    const glm::vec3& p = mesh.points[borders[i]];
    // Bounded search for points in one plane across x. A mesh that stays open only costs rays.
    const size_t last = std::min(borders.size(), i + 1000);
    for (size_t k = i + 1; k < last && mesh.points[borders[k]].x - p.x <= reach; ++k) {
      if (glm::distance(mesh.points[borders[k]], p) <= reach) same[borders[k]] = borders[i];
    }
  }
  std::vector<uint32_t> corners;
  corners.reserve(mesh.corners.size());
  for (size_t i = 0; i < mesh.corners.size(); i += 3) {
    const uint32_t a = same[mesh.corners[i]], b = same[mesh.corners[i + 1]], c = same[mesh.corners[i + 2]];
    if (a != b && b != c && c != a) corners.insert(corners.end(), {a, b, c});
  }
  mesh.corners = std::move(corners);
}

// True if all edges are paired and each connected component has positive volume. Components are tested one by
// one, since a light may be inside one with inverted winding.
bool is_closed(WeldedTriangles mesh) {
  // Too many corners for 32-bit counts; `open` is always conservative.
  if (mesh.corners.size() >= kNone) return false;
  std::vector<uint32_t> borders = border_points(mesh);
  if (!borders.empty()) {
    weld_borders(mesh, std::move(borders));
    if (!border_points(mesh).empty()) return false;
  }
  const std::vector<uint32_t> piece = connected_components(mesh);
  std::vector<double> volume(mesh.points.size(), 0);
  std::vector<bool> has_triangles(mesh.points.size(), false);
  for (size_t i = 0; i < mesh.corners.size(); i += 3) {
    const uint32_t* corner = &mesh.corners[i];
    // Relative to a point of the component, so that small distant components keep the sign of their volume.
    const glm::dvec3 from(mesh.points[piece[*corner]]);
    const glm::dvec3 a(mesh.points[corner[0]]), b(mesh.points[corner[1]]), c(mesh.points[corner[2]]);
    volume[piece[*corner]] += glm::dot(a - from, glm::cross(b - from, c - from));
    has_triangles[piece[*corner]] = true;
  }
  for (size_t p = 0; p < volume.size(); ++p) {
    if (has_triangles[p] && volume[p] <= 0) return false;
  }
  return true;
}

bool is_planar(const WeldedTriangles& mesh, glm::vec4& plane) {
  // Plane of the largest triangle; all others must lie in it except for rounding.
  glm::dvec3 normal(0);
  glm::dvec3 on_plane(0);
  glm::vec3 low(mesh.points[0]), high(low);
  for (size_t i = 0; i < mesh.corners.size(); i += 3) {
    const glm::dvec3 a(mesh.points[mesh.corners[i]]), b(mesh.points[mesh.corners[i + 1]]),
        c(mesh.points[mesh.corners[i + 2]]);
    const glm::dvec3 n = glm::cross(b - a, c - a);
    if (glm::dot(n, n) <= glm::dot(normal, normal)) continue;
    normal = n;
    on_plane = a;
  }
  if (glm::dot(normal, normal) <= 0) return false;
  normal = glm::normalize(normal);
  for (const glm::vec3& p : mesh.points) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const double tolerance = 1e-6 * glm::length(glm::dvec3(high - low));
  for (const glm::vec3& p : mesh.points) {
    if (std::abs(glm::dot(normal, glm::dvec3(p) - on_plane)) > tolerance) return false;
  }
  plane = glm::vec4(normal, -glm::dot(normal, on_plane));
  return true;
}

}  // namespace

Caster classify_caster(const Scene& scene, const Mesh& mesh) {
  Caster caster;
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    if (drawn_alpha_mode(scene.materials[scene.primitives[p].material]) != AlphaMode::opaque) return caster;
  }
  WeldedTriangles welded = weld(scene, mesh);
  if (welded.corners.empty()) return caster;
  if (is_planar(welded, caster.plane_node)) {
    caster.shape = CasterShape::planar;
  } else if (is_closed(std::move(welded))) {
    caster.shape = CasterShape::closed;
  }
  return caster;
}

std::vector<Caster> classify_casters(const Scene& scene) {
  std::vector<Caster> casters(scene.meshes.size());
  parallel_for(casters.size(), [&](size_t m) { casters[m] = classify_caster(scene, scene.meshes[m]); });
  return casters;
}

}  // namespace fire3dv::scene
