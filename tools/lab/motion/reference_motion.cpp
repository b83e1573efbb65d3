#include "tools/lab/motion/reference_motion.h"

#include <cmath>

namespace fire3dv::motion {

wire::Affine3x4 known_pose(int64_t sim_time_ns) {
  const double angle_rad = static_cast<double>(sim_time_ns) * 1e-9;
  const auto c = static_cast<float>(std::cos(angle_rad)), s = static_cast<float>(std::sin(angle_rad));
  wire::Affine3x4 pose;
  pose.m = {c, -s, 0, c, s, c, 0, s, 0, 0, 1, 0};
  return pose;
}

double distance_m(const wire::Affine3x4& a, const wire::Affine3x4& b) {
  const auto along = [&](size_t i) { return static_cast<double>(a.m[i]) - static_cast<double>(b.m[i]); };
  return std::hypot(along(3), along(7), along(11));
}

}  // namespace fire3dv::motion
