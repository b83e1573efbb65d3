#include "convert/sdf/sdf_prism.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>

#include "convert/mesh/geometry/polygon_holes.h"
#include "convert/mesh/geometry/triangulate.h"

namespace fire3dv::convert {
namespace {

constexpr double kMaxPrism_m = 1e9;

using Ring = std::vector<glm::dvec2>;

double doubled_area(const Ring& ring) {
  double area = 0;
  for (size_t i = 2; i < ring.size(); ++i) {
    const glm::dvec2 a = ring[i - 1] - ring[0], b = ring[i] - ring[0];
    area += a.x * b.y - a.y * b.x;
  }
  return area;
}

// Without repeated points, counter-clockwise; empty for a polygon without area.
Ring ring_of(const std::vector<glm::dvec2>& polygon) {
  Ring ring;
  for (const glm::dvec2& point : polygon) {
    if (!(std::abs(point.x) <= kMaxPrism_m) || !(std::abs(point.y) <= kMaxPrism_m)) return {};
    if (ring.empty() || point != ring.back()) ring.push_back(point);
  }
  if (ring.size() > 1 && ring.front() == ring.back()) ring.pop_back();
  const double area = doubled_area(ring);
  if (area < 0) std::reverse(ring.begin(), ring.end());
  return area != 0 ? ring : Ring();
}

bool contains(const Ring& ring, const glm::dvec2& p) {
  bool inside = false;
  for (size_t i = 0; i < ring.size(); ++i) {
    const glm::dvec2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) inside = !inside;
  }
  return inside;
}

// By most of three points, since one of them may lie on the other ring.
bool is_inside(const Ring& inner, const Ring& outer) {
  int inside = 0;
  for (size_t i = 0; i < 3; ++i) inside += contains(outer, inner[i * inner.size() / 3]) ? 1 : 0;
  return inside >= 2;
}

void add_caps(const std::vector<Ring>& rings, double height, Surface& surface, Prisms& prisms) {
  std::vector<HoleJoiner::Ring> in_plane(rings.size());
  std::vector<glm::dvec3> points;
  for (size_t i = 0; i < rings.size(); ++i) {
    for (const glm::dvec2& point : rings[i]) in_plane[i].emplace_back(point, 0);
    points.insert(points.end(), in_plane[i].begin(), in_plane[i].end());
  }
  std::vector<uint32_t> outline = HoleJoiner().join(in_plane);
  if (outline.empty()) {
    prisms.notes.emplace_back("a <polyline> crosses another one: holes are filled");
    outline.resize(rings[0].size());
    std::iota(outline.begin(), outline.end(), uint32_t{0});
  }
  std::vector<glm::dvec3> corners;
  for (const uint32_t point : outline) corners.push_back(points[point]);
  PolygonTriangulator triangulator;
  const std::vector<PolygonTriangulator::Triangle>& triangles = triangulator.triangulate(corners);
  if (!triangulator.warning().empty()) prisms.notes.push_back("<polyline>: " + triangulator.warning());
  for (const double z : {0.0, height}) {
    const auto first = static_cast<uint32_t>(surface.positions.size());
    for (const glm::dvec3& point : points) {
      surface.positions.push_back(glm::dvec3(point.x, point.y, z));
      surface.normals.emplace_back(0, 0, z > 0 ? 1 : -1);
      surface.uvs.emplace_back(point.x, -point.y);
    }
    for (const auto& [a, b, c] : triangles) {
      const uint32_t second = outline[z > 0 ? b : c], third = outline[z > 0 ? c : b];
      surface.indices.insert(surface.indices.end(), {first + outline[a], first + second, first + third});
    }
  }
}

// The solid is on the left of the ring.
void add_walls(const Ring& ring, double height, Surface& surface) {
  for (size_t i = 0; i < ring.size(); ++i) {
    const glm::dvec2 a = ring[i], b = ring[(i + 1) % ring.size()];
    const glm::dvec2 along = glm::normalize(b - a);
    const auto first = static_cast<uint32_t>(surface.positions.size());
    for (const auto& [point, z] : {std::pair(a, 0.0), {b, 0.0}, {b, height}, {a, height}}) {
      surface.positions.push_back(glm::dvec3(point, z));
      surface.normals.push_back(glm::dvec3(along.y, -along.x, 0));
      surface.uvs.emplace_back(point == a ? 0 : 1, z > 0 ? 0 : 1);
    }
    for (const uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) surface.indices.push_back(first + k);
  }
}

}  // namespace

// Even-odd: a ring inside an even number of others is an outline, one inside an odd number is a hole of the
// innermost outline around it.
Prisms prisms_of(const std::vector<SdfShape::Polyline>& lines) {
  Prisms prisms;
  std::vector<Ring> rings;
  for (const SdfShape::Polyline& line : lines) {
    rings.push_back(ring_of(line.points));
    if (rings.back().empty() || !(line.height > 0 && line.height <= kMaxPrism_m)) return prisms;
  }
  std::vector<std::vector<size_t>> around(rings.size());
  for (size_t inner = 0; inner < rings.size(); ++inner)
    for (size_t outer = 0; outer < rings.size(); ++outer)
      if (inner != outer && is_inside(rings[inner], rings[outer])) around[inner].push_back(outer);
  for (size_t outline = 0; outline < rings.size(); ++outline) {
    const size_t depth = around[outline].size();
    if (depth % 2 == 1) continue;
    std::vector<Ring> with_holes{rings[outline]};
    for (size_t hole = 0; hole < rings.size(); ++hole) {
      const std::vector<size_t>& outer = around[hole];
      if (outer.size() != depth + 1 || std::find(outer.begin(), outer.end(), outline) == outer.end())
        continue;
      with_holes.push_back(rings[hole]);
      std::reverse(with_holes.back().begin(), with_holes.back().end());
    }
    Surface& surface = prisms.surfaces.emplace_back();
    add_caps(with_holes, lines[outline].height, surface, prisms);
    for (const Ring& ring : with_holes) add_walls(ring, lines[outline].height, surface);
  }
  return prisms;
}

}  // namespace fire3dv::convert
