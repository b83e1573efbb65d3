// Geometry of a camera: projection, CameraInfo numbers (sensor_msgs), and poses between the frames of REP 103
// and the renderer's cameras, which look along -Z with +Y up.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "adapters/ros2/images/camera_spec.h"

namespace fire3dv::ros2 {

struct Intrinsics {
  double fx = 0, fy = 0, cx = 0, cy = 0;  // pixels; the centre of the top left pixel is (0, 0)
};
Intrinsics intrinsics(const CameraSpec& camera);

// Numbers of sensor_msgs/CameraInfo. Without a lens the model is plumb_bob with five zeros, as calibrated
// cameras of ROS have it. p has no rectification: it equals k with a zero column.
struct CalibrationNumbers {
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k{}, r{};
  std::array<double, 12> p{};
};
CalibrationNumbers calibration(const Intrinsics& projection, Lens lens,
                               const std::array<double, 5>& lens_coefficients);

struct RigidTransform {
  std::array<double, 3> translation{};
  std::array<double, 4> rotation{0, 0, 0, 1};  // quaternion x y z w, w >= 0
};

// 3x4, row-major, as fire3dv/image.h takes it.
using Matrix34 = std::array<double, 12>;

// Pose of the optical frame in the camera's parent: xyz and rpy (fixed axes, as URDF) of the body frame, and
// the turn from body to optical. Identity if the parent is the optical frame.
Matrix34 parent_from_optical(const CameraSpec& camera);
// Pose of the renderer's camera in the optical frame's parent: parent_from_optical * diag(1, -1, -1).
Matrix34 parent_from_camera(const Matrix34& parent_from_optical);
RigidTransform rigid_transform(const Matrix34& matrix);
Matrix34 multiply(const Matrix34& a, const Matrix34& b);

}  // namespace fire3dv::ros2
