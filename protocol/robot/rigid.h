// Rigid and affine transforms in double precision: 3x4 matrices, row-major, [row * 4 + column].
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace fire3dv::robot {

using Vector = std::array<double, 3>;
using Quaternion = std::array<double, 4>;  // x y z w

struct Transform {
  std::array<double, 12> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

  Transform operator*(const Transform& b) const {
    Transform product;
    for (size_t row = 0; row < 3; ++row)
      for (size_t column = 0; column < 4; ++column) {
        double sum = column == 3 ? m[row * 4 + 3] : 0;
        for (size_t k = 0; k < 3; ++k) sum += m[row * 4 + k] * b.m[k * 4 + column];
        product.m[row * 4 + column] = sum;
      }
    return product;
  }
};

inline Transform translation(const Vector& v) {
  Transform t;
  for (size_t row = 0; row < 3; ++row) t.m[row * 4 + 3] = v[row];
  return t;
}

// Rotation by a unit quaternion.
inline Transform rotation(const Quaternion& q) {
  const auto [x, y, z, w] = q;
  return {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 0,  //
           2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), 0,  //
           2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), 0}};
}

// Rotation about a unit axis.
inline Transform rotation(const Vector& axis, double angle_rad) {
  const auto [x, y, z] = axis;
  const double c = std::cos(angle_rad), s = std::sin(angle_rad), v = 1 - c;
  return {{c + x * x * v, x * y * v - z * s, x * z * v + y * s, 0,  //
           y * x * v + z * s, c + y * y * v, y * z * v - x * s, 0,  //
           z * x * v - y * s, z * y * v + x * s, c + z * z * v, 0}};
}

// Of a rigid transform.
inline Transform inverse(const Transform& t) {
  Transform result;
  for (size_t row = 0; row < 3; ++row) {
    double moved = 0;
    for (size_t k = 0; k < 3; ++k) {
      result.m[row * 4 + k] = t.m[k * 4 + row];
      moved -= t.m[k * 4 + row] * t.m[k * 4 + 3];
    }
    result.m[row * 4 + 3] = moved;
  }
  return result;
}

// Unit quaternion of a rotation; w is not negative.
inline Quaternion quaternion_of(const Transform& t) {
  const auto at = [&](size_t row, size_t column) { return t.m[row * 4 + column]; };
  Quaternion q{};
  const double trace = at(0, 0) + at(1, 1) + at(2, 2);
  if (trace > 0) {
    const double s = 2 * std::sqrt(trace + 1);
    q = {(at(2, 1) - at(1, 2)) / s, (at(0, 2) - at(2, 0)) / s, (at(1, 0) - at(0, 1)) / s, s / 4};
  } else {
    const size_t i = at(0, 0) >= at(1, 1) && at(0, 0) >= at(2, 2) ? 0 : at(1, 1) >= at(2, 2) ? 1 : 2;
    const size_t j = (i + 1) % 3, k = (i + 2) % 3;
    const double s = 2 * std::sqrt(1 + at(i, i) - at(j, j) - at(k, k));
    q[i] = s / 4;
    q[j] = (at(j, i) + at(i, j)) / s;
    q[k] = (at(k, i) + at(i, k)) / s;
    q[3] = (at(k, j) - at(j, k)) / s;
  }
  const double size = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
  for (double& number : q) number /= q[3] < 0 ? -size : size;
  return q;
}

inline double length(const Vector& v) {
  return std::hypot(v[0], v[1], v[2]);
}

inline double length(const Quaternion& q) {
  return std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
}

}  // namespace fire3dv::robot
