#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "convert/sdf/sdf_shapes.h"

namespace fire3dv::convert {
namespace {

double area_of(const glm::dvec2& a, const glm::dvec2& b,
               const glm::dvec2& c) {  // doubled; counter-clockwise > 0
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool is_inside(const glm::dvec2& p, const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  return area_of(a, b, p) >= 0 && area_of(b, c, p) >= 0 && area_of(c, a, p) >= 0;
}

// Triangles of a counter-clockwise polygon, by ear clipping; empty if there are none.
std::vector<uint32_t> ears_of(const std::vector<glm::dvec2>& points) {
  std::vector<uint32_t> left(points.size()), triangles;
  for (uint32_t i = 0; i < left.size(); ++i) left[i] = i;
  while (left.size() > 2) {
    bool found = false;
    for (size_t i = 0; i < left.size() && !found; ++i) {
      const uint32_t a = left[(i + left.size() - 1) % left.size()], b = left[i],
                     c = left[(i + 1) % left.size()];
      const double area = area_of(points[a], points[b], points[c]);
      if (area < 0) continue;
      bool is_ear = true;
      for (size_t k = 0; k < left.size() && is_ear && area > 0; ++k) {
        const uint32_t p = left[k];
        const bool is_corner = points[p] == points[a] || points[p] == points[b] || points[p] == points[c];
        is_ear = is_corner || !is_inside(points[p], points[a], points[b], points[c]);
      }
      if (!is_ear) continue;
      if (area > 0) triangles.insert(triangles.end(), {a, b, c});
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
      found = true;
    }
    if (!found) return {};
  }
  return triangles;
}

}  // namespace

Surface prism(const std::vector<glm::dvec2>& polygon, double height) {
  constexpr double kLargest = 1e9;
  std::vector<glm::dvec2> points;
  for (const glm::dvec2& point : polygon) {
    if (!(std::abs(point.x) <= kLargest) || !(std::abs(point.y) <= kLargest)) return {};
    if (points.empty() || point != points.back()) points.push_back(point);
  }
  if (points.size() > 1 && points.front() == points.back()) points.pop_back();
  if (points.size() < 3 || !(height > 0 && height <= kLargest)) return {};
  double area = 0;
  for (size_t i = 0; i < points.size(); ++i)
    area += area_of(points[0], points[i], points[(i + 1) % points.size()]);
  if (area < 0) std::vector<glm::dvec2>(points.rbegin(), points.rend()).swap(points);
  const std::vector<uint32_t> triangles = ears_of(points);
  Surface surface;
  if (triangles.empty()) return surface;
  for (const double z : {0.0, height}) {
    const auto first = static_cast<uint32_t>(surface.positions.size());
    for (const glm::dvec2& point : points) {
      surface.positions.push_back(glm::dvec3(point, z));
      surface.normals.emplace_back(0, 0, z > 0 ? 1 : -1);
      surface.uvs.emplace_back(point.x, -point.y);
    }
    for (size_t i = 0; i + 2 < triangles.size(); i += 3) {
      const uint32_t a = triangles[i], b = triangles[i + 1], c = triangles[i + 2];
      surface.indices.insert(surface.indices.end(),
                             {first + a, first + (z > 0 ? b : c), first + (z > 0 ? c : b)});
    }
  }
  for (size_t i = 0; i < points.size(); ++i) {
    const glm::dvec2 a = points[i], b = points[(i + 1) % points.size()];
    const glm::dvec2 along = glm::normalize(b - a);
    const auto first = static_cast<uint32_t>(surface.positions.size());
    for (const auto& [point, z] : {std::pair(a, 0.0), {b, 0.0}, {b, height}, {a, height}}) {
      surface.positions.push_back(glm::dvec3(point, z));
      surface.normals.push_back(glm::dvec3(along.y, -along.x, 0));
      surface.uvs.emplace_back(point == a ? 0 : 1, z > 0 ? 0 : 1);
    }
    for (const uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) surface.indices.push_back(first + k);
  }
  return surface;
}

}  // namespace fire3dv::convert
