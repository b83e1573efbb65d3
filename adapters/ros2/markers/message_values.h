// Numbers, frames, poses and colours of ROS 2 messages, checked: shared by the conversions to markers.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "adapters/ros2/dds/topics.h"
#include "adapters/ros2/tf/frames.h"
#include "base/error.h"

namespace fire3dv::ros2 {

constexpr double kMaxCoordinate = 1e9;  // metres

inline bool is_coordinate(double value) {
  return std::isfinite(value) && std::abs(value) <= kMaxCoordinate;
}

inline std::string frame_of(const std_msgs_msg_dds__Header_& header) {
  const std::string frame = header.frame_id ? header.frame_id : "";
  return frame.starts_with('/') ? frame.substr(1) : frame;
}

// A quaternion of zeros is no rotation, as in rviz.
inline Result<Transform> transform_of_pose(const geometry_msgs_msg_dds__Pose_& pose) {
  Transform transform{{pose.position.x, pose.position.y, pose.position.z},
                      {pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w}};
  for (const double value : transform.translation)
    if (!is_coordinate(value)) return Error{"its position is not finite"};
  double length = 0;
  for (const double value : transform.rotation) length += value * value;
  if (!std::isfinite(length)) return Error{"its orientation is not finite"};
  transform.rotation = length < 1e-12 ? std::array<double, 4>{0, 0, 0, 1} : normalized(transform.rotation);
  return transform;
}

inline uint8_t byte_of(float share) {
  return static_cast<uint8_t>(std::lround(255 * std::clamp(std::isfinite(share) ? share : 0.0f, 0.0f, 1.0f)));
}
inline void append(std::vector<uint8_t>& colors, const std_msgs_msg_dds__ColorRGBA_& color) {
  for (const float share : {color.r, color.g, color.b, color.a}) colors.push_back(byte_of(share));
}
inline void append(std::vector<float>& positions, double x, double y, double z) {
  for (const double value : {x, y, z}) positions.push_back(static_cast<float>(value));
}

}  // namespace fire3dv::ros2
