#include "protocol/record/rigid_part.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace fire3dv::record {
namespace {

using Matrix4 = std::array<std::array<double, 4>, 4>;

// Eigenvector of the largest eigenvalue of a symmetric matrix, by Jacobi rotations. They always converge; for
// 4x4 a few sweeps reach full precision.
std::array<double, 4> principal_vector(Matrix4 a) {
  constexpr int kSweeps = 12;
  Matrix4 vectors{};
  for (size_t i = 0; i < 4; ++i) vectors[i][i] = 1;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double off = 0, on = 0;
    for (size_t i = 0; i < 4; ++i)
      for (size_t j = 0; j < 4; ++j) (i == j ? on : off) += a[i][j] * a[i][j];
    if (off <= 1e-34 * on || off == 0) break;
    for (size_t p = 0; p < 3; ++p) {
      for (size_t q = p + 1; q < 4; ++q) {
        if (a[p][q] == 0) continue;
        const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        const double t = (theta >= 0 ? 1.0 : -1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1), s = t * c;
        for (size_t k = 0; k < 4; ++k) {
          const double kp = a[k][p], kq = a[k][q];
          a[k][p] = c * kp - s * kq;
          a[k][q] = s * kp + c * kq;
        }
        for (size_t k = 0; k < 4; ++k) {
          const double pk = a[p][k], qk = a[q][k];
          a[p][k] = c * pk - s * qk;
          a[q][k] = s * pk + c * qk;
          const double vp = vectors[k][p], vq = vectors[k][q];
          vectors[k][p] = c * vp - s * vq;
          vectors[k][q] = s * vp + c * vq;
        }
      }
    }
  }
  size_t best = 0;
  for (size_t i = 1; i < 4; ++i)
    if (a[i][i] > a[best][best]) best = i;
  return {vectors[0][best], vectors[1][best], vectors[2][best], vectors[3][best]};
}

}  // namespace

RigidPart rigid_part(const wire::Affine3x4d& map) {
  RigidPart result;
  const auto& m = map.m;
  result.translation = {m[3], m[7], m[11]};
  double largest = 0;
  for (const size_t i : {0, 1, 2, 4, 5, 6, 8, 9, 10}) largest = std::max(largest, std::abs(m[i]));
  if (largest == 0 || !std::isfinite(largest)) return result;
  const auto e = [&](size_t row, size_t column) { return m[row * 4 + column] / largest; };
  const double xx = e(0, 0), yy = e(1, 1), zz = e(2, 2);
  const double x = e(2, 1) - e(1, 2), y = e(0, 2) - e(2, 0), z = e(1, 0) - e(0, 1);
  const double xy = e(0, 1) + e(1, 0), xz = e(0, 2) + e(2, 0), yz = e(1, 2) + e(2, 1);
  // The unit quaternion q that maximises q^T K q (Horn's solution of the nearest rotation).
  std::array<double, 4> q = principal_vector({{{xx - yy - zz, xy, xz, x},
                                               {xy, yy - xx - zz, yz, y},
                                               {xz, yz, zz - xx - yy, z},
                                               {x, y, z, xx + yy + zz}}});
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const double sign = q[3] < 0 ? -1 : 1;  // canonical sign of q and -q: repeated values compress better
  for (size_t i = 0; i < 4; ++i) result.rotation_xyzw[i] = q[i] * sign / length;
  return result;
}

wire::Affine3x4d product(const wire::Affine3x4d& a, const wire::Affine3x4& b) {
  wire::Affine3x4d result;
  for (size_t row = 0; row < 3; ++row)
    for (size_t column = 0; column < 4; ++column) {
      double sum = column == 3 ? a.m[row * 4 + 3] : 0;
      for (size_t k = 0; k < 3; ++k) sum += a.m[row * 4 + k] * static_cast<double>(b.m[k * 4 + column]);
      result.m[row * 4 + column] = sum;
    }
  return result;
}

}  // namespace fire3dv::record
