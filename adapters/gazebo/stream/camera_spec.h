// Camera of a Gazebo world as image requests: the topics of its sensor, and what is rendered for them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <fire3dv/client.hpp>
#include <string>
#include <vector>

#include "adapters/gazebo/world/entities.h"
#include "base/error.h"

namespace fire3dv::gazebo {

struct CameraSpec {
  struct Topic {
    std::string name;
    uint32_t output = 0;  // FIRE3DV_IMAGE_*, published as an image
  };
  std::vector<Topic> images;
  std::string info_topic;           // of CameraInfo messages
  std::string frame_id;             // of messages: the unique scoped name of the sensor
  fire3dv_image_request request{};  // of all outputs
  int64_t period_ns = 0;            // of simulated time
};

// sensor: index of an entity that is a camera. Cameras have colours, depth cameras depth, RGB-D cameras both;
// other types of sensors (thermal, segmentation, boxes, wide angle) are an error. Without a topic of its own,
// the camera has that of Gazebo for the unique names of its models, link and sensor. The error is a reason
// without the name of the camera.
Result<CameraSpec> camera_spec(const TopLevel& item, size_t sensor, const std::string& world);

}  // namespace fire3dv::gazebo
