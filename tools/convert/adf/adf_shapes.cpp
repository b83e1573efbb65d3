#include "tools/convert/adf/adf_shapes.h"

#include <cmath>
#include <glm/gtc/constants.hpp>

namespace fire3dv::convert {
namespace {

constexpr uint32_t kSides = 32, kStacks = 32;  // AMBF's tessellation, for equal silhouettes
constexpr double kPlaneSize = 100;

uint32_t vertex(Surface& s, const glm::dvec3& position, const glm::dvec3& normal) {
  s.positions.emplace_back(position);
  s.normals.emplace_back(glm::normalize(normal));
  return static_cast<uint32_t>(s.positions.size() - 1);
}

void triangle(Surface& s, uint32_t a, uint32_t b, uint32_t c) {
  s.indices.insert(s.indices.end(), {a, b, c});
}

// Quad around `centre`, spanned by u and v, with normal u x v.
void quad(Surface& s, const glm::dvec3& centre, const glm::dvec3& u, const glm::dvec3& v) {
  const glm::dvec3 normal = glm::cross(u, v);
  const uint32_t a = vertex(s, centre - u - v, normal), b = vertex(s, centre + u - v, normal),
                 c = vertex(s, centre + u + v, normal), d = vertex(s, centre - u + v, normal);
  triangle(s, a, b, c);
  triangle(s, a, c, d);
}

glm::dvec2 around(uint32_t side) {
  const double angle = glm::two_pi<double>() * (side % kSides) / kSides;
  return {std::cos(angle), std::sin(angle)};
}

void disc(Surface& s, double z, double radius, double up) {
  if (radius <= 0) return;
  const uint32_t center = vertex(s, {0, 0, z}, {0, 0, up});
  uint32_t last = 0;
  for (uint32_t i = 0; i <= kSides; ++i) {
    const uint32_t next = vertex(s, {radius * around(i), z}, {0, 0, up});
    if (i > 0 && up > 0) triangle(s, center, last, next);
    if (i > 0 && up < 0) triangle(s, center, next, last);
    last = next;
  }
}

}  // namespace

Surface box_surface(const glm::dvec3& full_extents) {
  const glm::dvec3 h = 0.5 * full_extents;
  Surface s;
  if (!(h.x > 0 && h.y > 0 && h.z > 0)) return s;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 w(0), u(0), v(0);
    w[axis] = h[axis];
    u[(axis + 1) % 3] = h[(axis + 1) % 3];
    v[(axis + 2) % 3] = h[(axis + 2) % 3];
    quad(s, w, u, v);
    quad(s, -w, v, u);
  }
  return s;
}

Surface ellipsoid_surface(const glm::dvec3& semi_axes) {
  Surface s;
  if (!(semi_axes.x > 0 && semi_axes.y > 0 && semi_axes.z > 0)) return s;
  for (uint32_t stack = 0; stack <= kStacks; ++stack) {
    const double angle = glm::pi<double>() * stack / kStacks;
    for (uint32_t side = 0; side <= kSides; ++side) {
      const glm::dvec3 sphere(std::sin(angle) * around(side), -std::cos(angle));
      vertex(s, sphere * semi_axes, sphere / semi_axes);
      if (stack == 0 || side == 0) continue;
      const uint32_t d = static_cast<uint32_t>(s.positions.size() - 1), c = d - 1, b = d - kSides - 1,
                     a = b - 1;
      if (stack > 1) triangle(s, a, b, d);  // at the poles one of the two triangles is degenerate
      if (stack < kStacks) triangle(s, a, d, c);
    }
  }
  return s;
}

Surface cylinder_surface(double height, double bottom_radius, double top_radius) {
  Surface s;
  if (!(height > 0 && bottom_radius > 0)) return s;
  for (uint32_t side = 0; side <= kSides; ++side) {
    const glm::dvec2 at = around(side);
    const glm::dvec3 normal(at * height, bottom_radius - top_radius);
    vertex(s, {bottom_radius * at, -0.5 * height}, normal);
    vertex(s, {top_radius * at, 0.5 * height}, normal);
    if (side == 0) continue;
    const uint32_t d = static_cast<uint32_t>(s.positions.size() - 1), b = d - 1, c = d - 2, a = d - 3;
    triangle(s, a, b, d);
    if (top_radius > 0) triangle(s, a, d, c);
  }
  disc(s, -0.5 * height, bottom_radius, -1);
  disc(s, 0.5 * height, top_radius, 1);
  return s;
}

Surface plane_surface(const glm::dvec3& normal, double offset) {
  Surface s;
  const double length = glm::length(normal);
  if (!(length > 0)) return s;
  const glm::dvec3 n = normal / length;
  // Axes of the shortest rotation from Z to n, so that the square's edges match AMBF's.
  const double f = n.z > -0.999999 ? 1 / (1 + n.z) : 0;
  const glm::dvec3 u = f > 0 ? glm::dvec3(1 - f * n.x * n.x, -f * n.x * n.y, -n.x) : glm::dvec3(1, 0, 0);
  const glm::dvec3 v = glm::cross(n, u);
  quad(s, offset * normal, u * (0.5 * kPlaneSize), v * (0.5 * kPlaneSize));
  return s;
}

}  // namespace fire3dv::convert
