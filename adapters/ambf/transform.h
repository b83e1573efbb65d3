// Rigid transform in chai3d's layout: doubles, column-major, m[column][row], so that AMBF's frames are copied
// with memcpy. The stream frame is AMBF's world: Z up, metres.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace fire3dv::ambf {

struct Transform {
  double m[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
};

// Returns a_from_c for a_from_b and b_from_c. Both are affine; the last row is ignored.
inline Transform operator*(const Transform& a, const Transform& b) {
  Transform product;
  for (size_t column = 0; column < 4; ++column) {
    for (size_t row = 0; row < 3; ++row) {
      product.m[column][row] = a.m[0][row] * b.m[column][0] + a.m[1][row] * b.m[column][1] +
                               a.m[2][row] * b.m[column][2] + (column == 3 ? a.m[3][row] : 0.0);
    }
  }
  return product;
}

// Converts to the wire layout: 3 rows of 4 floats. Returns false, without writing, for numbers that the wire
// refuses.
inline bool to_pose(const Transform& from, float* pose) {
  constexpr double kMaxMagnitude = 1e12;  // limit of protocol/SPEC.md
  for (size_t column = 0; column < 4; ++column) {
    for (size_t row = 0; row < 3; ++row) {
      if (!(std::abs(from.m[column][row]) <= kMaxMagnitude)) return false;
    }
  }
  for (size_t row = 0; row < 3; ++row) {
    for (size_t column = 0; column < 4; ++column)
      pose[row * 4 + column] = static_cast<float>(from.m[column][row]);
  }
  return true;
}

}  // namespace fire3dv::ambf
