// Optical frames of the cameras on /tf_static.
#pragma once

#include <utility>
#include <vector>

#include "adapters/ros2/dds/names.h"
#include "adapters/ros2/dds/topics.h"
#include "adapters/ros2/images/camera_spec.h"
#include "base/error.h"

namespace fire3dv::ros2 {

class OpticalFrames {
 public:
  static Result<OpticalFrames> open(const Participant& participant, const Names& names);

  // Publishes parent -> optical of all cameras whose frame no other program publishes, as one message: late
  // readers get the last message only.
  Result<void> publish(const std::vector<CameraSpec>& cameras);

 private:
  explicit OpticalFrames(Entity writer) : writer_(std::move(writer)) {}

  Entity writer_;
};

}  // namespace fire3dv::ros2
