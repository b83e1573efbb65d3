// Cameras of a robot: <sensor> tags in the <gazebo reference="LINK"> elements of a URDF, as Gazebo and its
// classic plug-ins read them. The text is untrusted.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "adapters/ros2/images/camera_spec.h"
#include "base/error.h"

namespace fire3dv::ros2 {

struct SensorCameras {
  std::vector<CameraSpec> cameras;  // names are unique; at most kMaxCameras
  std::vector<std::string> warnings;
};

// Reads sensors of type camera, depth, depth_camera, rgbd_camera and segmentation_camera (and classic
// spellings). Other cameras (thermal, wide angle, several in one) and bad values give warnings; other sensors
// are skipped. A sensor looks along +X of its link; its frame_id is <optical_frame_id>, the plug-in's
// <frame_name>, or NAME_optical_frame. Fails if the text is not a robot description.
Result<SensorCameras> read_sensor_cameras(std::string_view urdf);

}  // namespace fire3dv::ros2
