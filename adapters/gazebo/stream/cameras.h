// Images of the world's cameras, published on the topics of their sensors as Gazebo would: rendered by the
// renderer of the first stream, at each sensor's rate of simulated time, while somebody subscribes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <fire3dv/client.hpp>
#include <map>
#include <string>
#include <vector>

#include "adapters/gazebo/stream/camera_spec.h"
#include "adapters/gazebo/stream/publisher.h"
#include "adapters/gazebo/wire/node.h"
#include "adapters/gazebo/world/entities.h"

namespace fire3dv::gazebo {

struct CameraChoice {
  bool all = false;
  std::vector<std::string> names;  // node names, or names of sensors
  bool any() const { return all || !names.empty(); }
};

class Cameras {
 public:
  explicit Cameras(CameraChoice choice) : choice_(std::move(choice)) {}

  // Chooses the cameras of a changed scene. type: a message type of the world, whose prefix is used.
  void update(const std::vector<TopLevel>& items, const std::string& world, const std::string& type);
  // A new epoch ends all requests.
  void restart();
  // Requests images of the frame that was just published, where one is due. Returns warnings.
  std::vector<std::string> request(Node& node, Publisher& publisher, int64_t sim_time_ns);
  // Publishes images that have arrived.
  std::vector<std::string> deliver(Node& node, Publisher& publisher);

 private:
  struct Camera;
  void advertise(Node& node, const std::string& topic, const char* type);
  void refuse(const std::string& name, Camera& camera, const std::string& reason);

  struct Camera {
    std::string node, digest;
    CameraSpec spec;
    int64_t due_ns = INT64_MIN, last_ns = INT64_MIN;
    uint64_t pending = 0;   // request without an image; 0: none
    unsigned refusals = 0;  // since the last image
    int64_t retry_ns = 0;   // monotonic: no request before
  };
  CameraChoice choice_;
  std::map<std::string, Camera> cameras_;  // by node name
  std::string prefix_;
  bool cannot_publish_ = false;
  std::vector<std::string> warnings_;
};

}  // namespace fire3dv::gazebo
