#include "renderer/scene/caster_shape.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <unordered_map>

namespace fire3dv::scene {
namespace {

struct PositionHash {
  size_t operator()(const glm::vec3& p) const {
    uint32_t bits[3];
    std::memcpy(bits, &p, sizeof(bits));
    return bits[0] * 73856093u ^ bits[1] * 19349663u ^ bits[2] * 83492791u;
  }
};

struct WeldedTriangles {
  std::vector<glm::vec3> points;
  std::vector<uint32_t> corners;  // three for each triangle; those without area are left out
};

WeldedTriangles weld(const Scene& scene, const Mesh& mesh) {
  WeldedTriangles welded;
  std::unordered_map<glm::vec3, uint32_t, PositionHash> known;
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    const Primitive& primitive = scene.primitives[p];
    if (primitive.topology != Topology::triangles) continue;
    std::vector<uint32_t> point_of_vertex(primitive.vertex_count);
    for (uint32_t v = 0; v < primitive.vertex_count; ++v) {
      const glm::vec3 position = scene.positions[primitive.first_vertex + v] + 0.0f;  // -0 becomes 0
      const auto [found, is_new] = known.try_emplace(position, static_cast<uint32_t>(welded.points.size()));
      if (is_new) welded.points.push_back(position);
      point_of_vertex[v] = found->second;
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

// Every edge is run through once in each direction, and the volume inside is positive; of each piece, since a
// lamp may stand inside one that is inside out.
bool is_closed(const WeldedTriangles& mesh) {
  std::vector<uint64_t> edges;
  edges.reserve(mesh.corners.size());
  const std::vector<uint32_t> piece = pieces_of(mesh);
  std::vector<double> volume(mesh.points.size(), 0);
  std::vector<bool> has_triangles(mesh.points.size(), false);
  for (size_t i = 0; i < mesh.corners.size(); i += 3) {
    const uint32_t* corner = &mesh.corners[i];
    for (int e = 0; e < 3; ++e) edges.push_back(uint64_t{corner[e]} << 32 | corner[(e + 1) % 3]);
    // From a point of the piece, so that a small one far off has its sign, too.
    const glm::dvec3 from(mesh.points[piece[*corner]]);
    const glm::dvec3 a(mesh.points[corner[0]]), b(mesh.points[corner[1]]), c(mesh.points[corner[2]]);
    volume[piece[*corner]] += glm::dot(a - from, glm::cross(b - from, c - from));
    has_triangles[piece[*corner]] = true;
  }
  std::sort(edges.begin(), edges.end());
  if (std::adjacent_find(edges.begin(), edges.end()) != edges.end()) return false;
  for (size_t p = 0; p < volume.size(); ++p) {
    if (has_triangles[p] && volume[p] <= 0) return false;
  }
  return std::all_of(edges.begin(), edges.end(), [&](uint64_t edge) {
    return std::binary_search(edges.begin(), edges.end(), edge << 32 | edge >> 32);
  });
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
  const WeldedTriangles welded = weld(scene, mesh);
  if (welded.corners.empty()) return caster;
  if (is_planar(welded, caster.plane_node)) {
    caster.shape = CasterShape::planar;
  } else if (is_closed(welded)) {
    caster.shape = CasterShape::closed;
  }
  return caster;
}

}  // namespace fire3dv::scene
