// Frames of the nodes of mesh files: node transforms without scales, which belong to the vertices.
#pragma once

#include <cmath>
#include <glm/glm.hpp>

namespace fire3dv::convert {

// Rotation and translation of a matrix. The rest, scales and shears, is rigid_part(m)^-1 * m.
inline glm::dmat4 rigid_part(const glm::dmat4& m) {
  constexpr double kFlat = 1e-12;
  const glm::dvec3 x(m[0]), y(m[1]);
  const glm::dvec3 across = glm::cross(x, y);
  glm::dmat4 rigid(1);
  if (glm::length(across) > kFlat * glm::length(x) * glm::length(y)) {
    const glm::dvec3 unit_x = glm::normalize(x), unit_z = glm::normalize(across);
    rigid[0] = glm::dvec4(unit_x, 0);
    rigid[1] = glm::dvec4(glm::cross(unit_z, unit_x), 0);
    rigid[2] = glm::dvec4(unit_z, 0);
  }
  rigid[3] = glm::dvec4(glm::dvec3(m[3]), 1);
  return rigid;
}

// Matrices of 32 bits in a file: what is left of a rotation is no scale.
inline glm::dmat4 without_rounding(glm::dmat4 m) {
  constexpr double kRounding = 1e-6;
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 3; ++r) {
      const double exact = c == r ? 1 : 0;
      if (c == 3 || std::abs(m[c][r] - exact) < kRounding) m[c][r] = exact;
    }
  }
  return m;
}

}  // namespace fire3dv::convert
