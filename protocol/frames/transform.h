// Rigid transforms as ROS 2 has them: translation in metres and unit quaternion x y z w.
#pragma once

#include <array>
#include <cmath>

namespace fire3dv::frames {

struct Transform {
  std::array<double, 3> translation{};
  std::array<double, 4> rotation{0, 0, 0, 1};  // x y z w

  bool operator==(const Transform&) const = default;
};

inline std::array<double, 4> multiply(const std::array<double, 4>& a, const std::array<double, 4>& b) {
  return {a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
          a[3] * b[1] + a[1] * b[3] + a[2] * b[0] - a[0] * b[2],
          a[3] * b[2] + a[2] * b[3] + a[0] * b[1] - a[1] * b[0],
          a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
}

inline std::array<double, 3> rotate(const std::array<double, 4>& q, const std::array<double, 3>& v) {
  const double x = 2 * (q[1] * v[2] - q[2] * v[1]);  // 2 q x v
  const double y = 2 * (q[2] * v[0] - q[0] * v[2]);
  const double z = 2 * (q[0] * v[1] - q[1] * v[0]);
  return {v[0] + q[3] * x + q[1] * z - q[2] * y, v[1] + q[3] * y + q[2] * x - q[0] * z,
          v[2] + q[3] * z + q[0] * y - q[1] * x};
}

inline std::array<double, 4> normalized(const std::array<double, 4>& q) {
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return {q[0] / length, q[1] / length, q[2] / length, q[3] / length};
}

// a_from_b * b_from_c = a_from_c
inline Transform operator*(const Transform& a_from_b, const Transform& b_from_c) {
  const std::array<double, 3> moved = rotate(a_from_b.rotation, b_from_c.translation);
  return {{a_from_b.translation[0] + moved[0], a_from_b.translation[1] + moved[1],
           a_from_b.translation[2] + moved[2]},
          multiply(a_from_b.rotation, b_from_c.rotation)};
}

inline Transform inverse(const Transform& t) {
  const std::array<double, 4> back = {-t.rotation[0], -t.rotation[1], -t.rotation[2], t.rotation[3]};
  const std::array<double, 3> moved = rotate(back, t.translation);
  return {{-moved[0], -moved[1], -moved[2]}, back};
}

// Linear in the translation, spherical by the shorter way in the rotation. share: 0 gives a, 1 gives b.
inline Transform interpolate(const Transform& a, const Transform& b, double share) {
  Transform between;
  for (size_t i = 0; i < 3; ++i)
    between.translation[i] = (1 - share) * a.translation[i] + share * b.translation[i];
  double cosine = 0;
  for (size_t i = 0; i < 4; ++i) cosine += a.rotation[i] * b.rotation[i];
  const double sign = cosine < 0 ? -1 : 1;
  double of_a = 1 - share, of_b = share;
  if (const double angle = std::acos(std::fmin(std::fabs(cosine), 1)); angle > 1e-6) {
    of_a = std::sin((1 - share) * angle) / std::sin(angle);
    of_b = std::sin(share * angle) / std::sin(angle);
  }
  for (size_t i = 0; i < 4; ++i) between.rotation[i] = of_a * a.rotation[i] + sign * of_b * b.rotation[i];
  between.rotation = normalized(between.rotation);
  return between;
}

// 3x4 matrix, row-major.
inline std::array<float, 12> matrix_of(const Transform& t) {
  const auto [x, y, z, w] = normalized(t.rotation);
  const auto& p = t.translation;
  const std::array<double, 12> m = {
      1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),     p[0],
      2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),     p[1],
      2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y), p[2]};
  std::array<float, 12> matrix{};
  for (size_t i = 0; i < m.size(); ++i) matrix[i] = static_cast<float>(m[i]);
  return matrix;
}

// Inverse of matrix_of() in double precision, for a matrix without scale.
Transform transform_of(const std::array<double, 12>& matrix);

}  // namespace fire3dv::frames
