#include "renderer/scene/caster_shape.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>
#include <span>

#include "renderer/scene/parallel.h"

namespace fire3dv::scene {
namespace {

// Numbers positions in the order of their first appearance. The seed is drawn anew each time, so that no file
// can choose positions that all fall on one slot.
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
  std::vector<uint32_t> corners;  // three for each triangle; those without area are left out
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

// Numbers the pieces that hang together: of each point its piece.
std::vector<uint32_t> pieces_of(const WeldedTriangles& mesh) {
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

// Ends of edges that are not run through once in each direction; none where a mesh is closed.
std::vector<uint32_t> points_at_borders(const WeldedTriangles& mesh) {
  // Edges of each point that is the lower one of their two: first_of[point] .. first_of[point + 1].
  std::vector<uint32_t> first_of(mesh.points.size() + 1, 0);
  const auto for_each_edge = [&](const auto& visit) {
    for (size_t i = 0; i < mesh.corners.size(); ++i) {
      const uint32_t from = mesh.corners[i], to = mesh.corners[i % 3 == 2 ? i - 2 : i + 1];
      visit(std::min(from, to), std::max(from, to), from > to);
    }
  };
  for_each_edge([&](uint32_t lower, uint32_t, bool) { ++first_of[lower + 1]; });
  std::partial_sum(first_of.begin(), first_of.end(), first_of.begin());
  std::vector<uint64_t> edges(mesh.corners.size());  // the upper point and the direction
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

// Joins points at borders that rounding has parted, such as where a full turn ends: sin(2 pi) is not quite 0.
// Far narrower than a texel of any shadow map, such a slit makes no difference to what a map may say.
void close_slits(WeldedTriangles& mesh, std::vector<uint32_t> borders) {
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
    // Where many lie in one plane across x the search ends early: a mesh that stays open only costs rays.
    const size_t last = std::min(borders.size(), i + 1000);
    for (size_t k = i + 1; k < last && mesh.points[borders[k]].x - p.x <= reach; ++k) {
      if (glm::distance(mesh.points[borders[k]], p) <= reach) same[borders[k]] = borders[i];
    }
  }
  std::vector<uint32_t> kept;
  kept.reserve(mesh.corners.size());
  for (size_t i = 0; i < mesh.corners.size(); i += 3) {
    const uint32_t a = same[mesh.corners[i]], b = same[mesh.corners[i + 1]], c = same[mesh.corners[i + 2]];
    if (a != b && b != c && c != a) kept.insert(kept.end(), {a, b, c});
  }
  mesh.corners = std::move(kept);
}

// Edges are paired, and the volume inside is positive; of each piece, since a lamp may stand inside one that
// is inside out.
bool is_closed(WeldedTriangles mesh) {
  if (mesh.corners.size() >= kNone)
    return false;  // more than can be counted here; open is always true enough
  std::vector<uint32_t> borders = points_at_borders(mesh);
  if (!borders.empty()) {
    close_slits(mesh, std::move(borders));
    if (!points_at_borders(mesh).empty()) return false;
  }
  const std::vector<uint32_t> piece = pieces_of(mesh);
  std::vector<double> volume(mesh.points.size(), 0);
  std::vector<bool> has_triangles(mesh.points.size(), false);
  for (size_t i = 0; i < mesh.corners.size(); i += 3) {
    const uint32_t* corner = &mesh.corners[i];
    // From a point of the piece, so that a small one far off has its sign, too.
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
  // The plane of the largest triangle; the others lie in it but for rounding.
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

Caster caster_of(const Scene& scene, const Mesh& mesh) {
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

std::vector<Caster> casters_of(const Scene& scene) {
  std::vector<Caster> casters(scene.meshes.size());
  parallel_for(casters.size(), [&](size_t m) { casters[m] = caster_of(scene, scene.meshes[m]); });
  return casters;
}

}  // namespace fire3dv::scene
