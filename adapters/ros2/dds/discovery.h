// Discovered participants and publishers of a domain: names for messages, and reasons for silence.
#pragma once

#include <string>
#include <unordered_map>
#include <vector>

#include "adapters/ros2/dds/participant.h"
#include "base/error.h"

namespace fire3dv::ros2 {

class Discovery {
 public:
  static Result<Discovery> open(const Participant& participant);

  // Takes news of discovery.
  void update();

  // For messages: process, host, or at least the id of a publisher, which may be gone already.
  std::string publisher_text(dds_instance_handle_t publication) const;

  // Other participants and their ROS topics, at most ten: "2 participants with the topics /a (pkg/msg/T)".
  std::string summary() const;

  struct News {
    std::string text;
    bool is_wrong_type;
  };
  // Publishers of a topic, each once: those with this type, and those with another one.
  std::vector<News> new_publishers(const std::string& topic, const std::string& ros_type);

 private:
  struct Remote {
    dds_instance_handle_t participant = 0;
    std::string topic, type, guid;
    bool is_reported = false;
  };

  std::string participant_text(dds_instance_handle_t participant) const;
  void take_participants();
  void take_publications();

  dds_entity_t own_ = 0;
  Entity participants_, publications_;
  dds_instance_handle_t own_handle_ = 0;
  std::unordered_map<dds_instance_handle_t, std::string> names_;         // of participants that are there
  std::unordered_map<dds_instance_handle_t, std::string> former_names_;  // also those that have gone
  std::unordered_map<dds_instance_handle_t, Remote> remotes_;
};

// Topic that is read, for messages about its publishers.
struct WatchedTopic {
  std::string topic, type;  // absolute ROS name; ROS type
  dds_entity_t reader;
};

// Policy that keeps a reader and publishers of its topic apart, since the last call: "reliability"; empty:
// none.
std::string new_incompatible_policy(dds_entity_t reader);

}  // namespace fire3dv::ros2
