#include "convert/mjcf/scene/view_frame.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fire3dv::convert {
namespace {

constexpr double kAspect = 4.0 / 3, kWithinMargins = 0.9;
constexpr double kLowest = std::numeric_limits<double>::lowest();

}  // namespace

ViewFrame::ViewFrame(const glm::dvec3& to_eye, double vertical_fov_rad) {
  const glm::dvec3 back = glm::normalize(to_eye);
  const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0, 0, 1), back));
  world_from_camera_ = glm::dmat3(right, glm::cross(back, right), back);
  const double up = kWithinMargins * std::tan(0.5 * vertical_fov_rad);
  tangents_ = {up * kAspect, up};
  above_.fill(kLowest);
  below_.fill(kLowest);
}

// An eye at (ex, ez) sees a point (x, z) below its right margin if x - ex <= tangent * (ez - z).
void ViewFrame::add(const glm::dvec3& point) {
  const glm::dvec3 p = glm::transpose(world_from_camera_) * point;
  for (int axis = 0; axis < 2; ++axis) {
    const auto i = static_cast<size_t>(axis);
    above_[i] = std::max(above_[i], p[axis] + tangents_[i] * p.z);
    below_[i] = std::max(below_[i], -p[axis] + tangents_[i] * p.z);
  }
  low_ = glm::min(low_, p);
  high_ = glm::max(high_, p);
}

double ViewFrame::radius() const {
  return 0.5 * glm::length(high_ - low_);
}

double ViewFrame::near_m() const {
  return 1e-3 * radius();
}

std::optional<glm::dmat4> ViewFrame::pose() const {
  if (!(low_.x <= high_.x) || !std::isfinite(radius()) || !(radius() > 0)) return std::nullopt;
  glm::dvec3 eye(0);
  eye.z = high_.z + near_m();
  for (size_t i = 0; i < 2; ++i) eye.z = std::max(eye.z, (above_[i] + below_[i]) / (2 * tangents_[i]));
  for (int axis = 0; axis < 2; ++axis) {
    const auto i = static_cast<size_t>(axis);
    // In the middle of what is at the mean distance, within the range that shows all.
    const double room = tangents_[i] * eye.z;
    const double least = above_[i] - room, most = room - below_[i];
    eye[axis] = std::clamp(0.5 * (low_[axis] + high_[axis]), std::min(least, most), std::max(least, most));
  }
  glm::dmat4 pose(world_from_camera_);
  pose[3] = glm::dvec4(world_from_camera_ * eye, 1);
  return pose;
}

}  // namespace fire3dv::convert
