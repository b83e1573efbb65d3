// Images of fire3dv-ros2: the cameras that its options select, of the command line and of the robot
// description.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <string_view>

#include "adapters/ros2/images/camera_images.h"
#include "adapters/ros2/images/camera_options.h"

namespace fire3dv::ros2 {

class ImageOutput {
 public:
  // Opens the cameras of --camera. The participant outlives this object.
  static Result<std::unique_ptr<ImageOutput>> open(const Participant& participant, const Names& names,
                                                   ImageOptions options, std::string frame_prefix,
                                                   CameraImages::Log log);

  // Opens the selected cameras of a robot description. Cameras that are there already stay as they are.
  void set_description(std::string_view urdf);

  // Call it after each turn of the pose stream, and again after poll_interval() at the latest. It does not
  // wait.
  void poll(fire3dv_stream* stream, const FrameBuffer& buffer, const StreamedFrames& streamed);
  std::chrono::milliseconds poll_interval() const { return images_->poll_interval(); }

  void log_counts() { images_->log_counts(); }

 private:
  ImageOutput(ImageOptions options, std::string frame_prefix, CameraImages::Log log,
              std::unique_ptr<CameraImages> images);

  ImageOptions options_;
  std::string frame_prefix_;
  CameraImages::Log log_;
  std::unique_ptr<CameraImages> images_;
};

}  // namespace fire3dv::ros2
