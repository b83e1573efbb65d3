#include "adapters/ros2/images/camera_model.h"

#include <cmath>

namespace fire3dv::ros2 {
namespace {

// body_from_optical: the optical x (right) is -y of the body, y (down) is -z, z (forward) is x.
constexpr Matrix34 kBodyFromOptical{0, 0, 1, 0, -1, 0, 0, 0, 0, -1, 0, 0};
constexpr Matrix34 kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

Matrix34 from_xyz_rpy(const std::array<double, 3>& xyz, const std::array<double, 3>& rpy) {
  const double cr = std::cos(rpy[0]), sr = std::sin(rpy[0]);
  const double cp = std::cos(rpy[1]), sp = std::sin(rpy[1]);
  const double cy = std::cos(rpy[2]), sy = std::sin(rpy[2]);
  return {cy * cp,
          cy * sp * sr - sy * cr,
          cy * sp * cr + sy * sr,
          xyz[0],
          sy * cp,
          sy * sp * sr + cy * cr,
          sy * sp * cr - cy * sr,
          xyz[1],
          -sp,
          cp * sr,
          cp * cr,
          xyz[2]};
}

}  // namespace

Intrinsics intrinsics(const CameraSpec& camera) {
  Intrinsics result;
  result.fx = camera.fx > 0 ? camera.fx : camera.width / (2 * std::tan(camera.fov / 2));
  result.fy = camera.fy > 0 ? camera.fy : result.fx;
  result.cx = camera.cx >= 0 ? camera.cx : (camera.width - 1.0) / 2;
  result.cy = camera.cy >= 0 ? camera.cy : (camera.height - 1.0) / 2;
  return result;
}

CalibrationNumbers calibration(const Intrinsics& projection, Lens lens,
                               const std::array<double, 5>& lens_coefficients) {
  CalibrationNumbers numbers;
  const bool is_equidistant = lens == Lens::equidistant;
  numbers.distortion_model = is_equidistant ? "equidistant" : "plumb_bob";
  numbers.d.assign(is_equidistant ? 4 : 5, 0.0);
  if (lens != Lens::none)
    for (size_t i = 0; i < numbers.d.size(); ++i) numbers.d[i] = lens_coefficients[i];
  const auto& [fx, fy, cx, cy] = projection;
  numbers.k = {fx, 0, cx, 0, fy, cy, 0, 0, 1};
  numbers.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  numbers.p = {fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0};
  return numbers;
}

Matrix34 multiply(const Matrix34& a, const Matrix34& b) {
  Matrix34 product{};
  for (size_t row = 0; row < 3; ++row) {
    for (size_t column = 0; column < 4; ++column) {
      double sum = column == 3 ? a[4 * row + 3] : 0;
      for (size_t i = 0; i < 3; ++i) sum += a[4 * row + i] * b[4 * i + column];
      product[4 * row + column] = sum;
    }
  }
  return product;
}

Matrix34 parent_from_optical(const CameraSpec& camera) {
  if (camera.is_in_optical_frame()) return kIdentity;
  return multiply(from_xyz_rpy(camera.xyz, camera.rpy), kBodyFromOptical);
}

Matrix34 parent_from_camera(const Matrix34& parent_from_optical) {
  return multiply(parent_from_optical, {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0});
}

RigidTransform rigid_transform(const Matrix34& m) {
  // Each candidate is 4 |component|; the greatest divides best.
  const double xx = m[0], yy = m[5], zz = m[10];
  const std::array<double, 4> squares{1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz, 1 + xx + yy + zz};
  size_t greatest = 3;
  for (size_t i = 0; i < 4; ++i)
    if (squares[i] > squares[greatest]) greatest = i;
  const double yx = m[4] + m[1], zx = m[8] + m[2], zy = m[9] + m[6];
  const double x = m[9] - m[6], y = m[2] - m[8], z = m[4] - m[1];
  const std::array<std::array<double, 4>, 4> rows{
      {{squares[0], yx, zx, x}, {yx, squares[1], zy, y}, {zx, zy, squares[2], z}, {x, y, z, squares[3]}}};
  RigidTransform result;
  result.translation = {m[3], m[7], m[11]};
  result.rotation = rows[greatest];
  double length = 0;
  for (const double component : result.rotation) length += component * component;
  length = std::copysign(std::sqrt(length), result.rotation[3]);
  for (double& component : result.rotation) component /= length;
  return result;
}

}  // namespace fire3dv::ros2
