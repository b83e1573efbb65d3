// Options of fire3dv-ros2 for images: --camera, --sensor, --sensors, and defaults of all cameras.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "adapters/ros2/images/camera_spec.h"
#include "base/error.h"

namespace fire3dv::ros2 {

// Values of the command line, as CLI11 sets them.
struct CameraArguments {
  std::vector<std::string> cameras, sensors;
  std::string size, labels;
  double rate_hz = -1;  // not given
  uint32_t jpeg_quality = 95;
  bool all_sensors = false, depth = false, compressed = false;
};
void add_camera_options(CLI::App& app, CameraArguments& arguments);

struct ImageOptions {
  std::vector<CameraSpec> cameras;    // of --camera, complete
  std::vector<CameraOption> sensors;  // of --sensor
  bool all_sensors = false;
  CameraArguments arguments;  // defaults that were given

  bool is_empty() const { return cameras.empty() && sensors.empty() && !all_sensors; }
  bool needs_description() const { return !sensors.empty() || all_sensors; }
};

// Checks the arguments. The error is for the user.
Result<ImageOptions> image_options(const CameraArguments& arguments);

struct RobotCameras {
  std::vector<CameraSpec> cameras;
  std::vector<std::string> warnings;
};

// Cameras of a robot description that the options select, with their settings. frame_prefix: of the robot's
// frames in tf.
RobotCameras robot_cameras(const ImageOptions& options, std::string_view urdf,
                           const std::string& frame_prefix);

}  // namespace fire3dv::ros2
