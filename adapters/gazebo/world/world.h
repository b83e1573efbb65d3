// State of a Gazebo world: its models and lights with their node names, and the newest pose of each. Turns
// the relative poses of pose topics into global ones. No network; one thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "adapters/gazebo/world/entities.h"

namespace fire3dv::gazebo {

// Pose topics of a world. dynamic: models that are not static, and their links; full: everything.
enum class PoseTopic : uint8_t { dynamic, full };

class World {
 public:
  struct Changes {
    std::vector<size_t> added;     // indices into items()
    std::vector<size_t> restored;  // nodes of the scene file that had been removed, with equal shapes
    std::vector<TopLevel> removed;
    bool empty() const { return added.empty() && restored.empty() && removed.empty(); }
  };
  // Compares with the whole scene. Models with equal names and shapes stay, also under other ids, as after a
  // restart.
  Changes update(const pb::Scene& scene);
  // Removes models and lights by id. Returns false as the second if an id is part of a model that stays.
  std::pair<Changes, bool> remove(const pb::UInt32V& ids);

  const std::vector<TopLevel>& items() const { return items_; }
  TopLevel& item(size_t index) { return items_[index]; }

  struct PoseResult {
    bool is_frame = false;     // a new whole frame: publish it
    bool is_reset = false;     // simulated time went back
    bool has_unknown = false;  // an id is not in the scene: request it
    int64_t sim_time_ns = 0;
  };
  // now_ns: arrival, monotonic. Poses that are not finite are ignored and counted.
  PoseResult apply(const pb::PoseV& message, PoseTopic topic, int64_t now_ns);
  uint64_t invalid_poses() const { return invalid_poses_; }
  // Forgets the times of pose messages, for another server.
  void forget_times();

  // Nodes of streamed items: models, links and lights. Visuals and sensors move with their links.
  std::vector<std::string> node_names() const;
  // 12 floats each: world_from_node, row-major, Z up.
  void write_poses(std::vector<float>& poses) const;

  std::vector<std::string> take_warnings() { return std::exchange(warnings_, {}); }

 private:
  void index();
  void retire(const TopLevel& item);

  std::vector<TopLevel> items_;
  std::map<std::string, TopLevel> retired_;  // removed items of the scene file, by shape
  convert::SdfNames names_;
  std::map<uint32_t, std::pair<size_t, size_t>> by_id_;  // item and entity
  struct Last {
    bool is_set = false;
    int64_t sim_time_ns = 0, arrival_ns = 0;
  };
  std::array<Last, 2> last_;                      // by topic
  Last frame_;                                    // newest frame
  std::vector<uint32_t> dynamic_ids_;             // of the last dynamic message, sorted
  std::set<uint32_t> unknown_ids_, ignored_ids_;  // since the last update; in no scene
  uint64_t invalid_poses_ = 0;
  std::vector<std::string> warnings_;
};

}  // namespace fire3dv::gazebo
