// Streams to renderers: descriptions, pose frames, and the robot as an added node where the scene lacks its
// links.
#pragma once

#include <fire3dv/markers.h>
#include <fire3dv/client.hpp>

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "adapters/ros2/robot/joint_scalars.h"
#include "base/error.h"
#include "protocol/wire/limits.h"

namespace fire3dv::ros2 {

class Renderers {
 public:
  static constexpr size_t kSceneBudgetBytes = wire::kMaxSceneEditBytes;  // of a stream: robot and markers

  static Result<Renderers> open(const std::vector<std::string>& uris, const Security& security,
                                size_t scene_budget_bytes = kSceneBudgetBytes);

  // offsets: body_from_node, none or one per name.
  Result<void> describe(std::vector<std::string> names, std::vector<Pose> offsets);
  Result<void> publish(int64_t time_ns, const std::vector<Pose>& poses, bool is_discontinuity);

  // The robot: renderers whose scene has less than half of the described names get it as a node. It stays
  // until another one comes.
  Result<void> set_robot(std::vector<uint8_t> glb);

  // Shows a marker in all renderers, or clears it (null).
  Result<void> show_marker(const std::string& name, const fire3dv_marker* marker);

  // Sets the values of the group in all streams; declares it before, unless it is.
  Result<void> show_scalars(ScalarGroup& group);

  // Processes messages of the renderers and reports news by `log`. Call it ten times a second.
  Result<void> poll(const std::function<void(const std::string&)>& log);

  bool is_described() const { return is_described_; }
  // Time of the frame published last; none: nothing was published.
  std::optional<int64_t> published_time_ns() const { return last_time_ns_; }
  // Stream of the first URI, whose renderer draws the images.
  fire3dv_stream* first_stream() const { return targets_.front().stream.get(); }
  // Name or path by which that renderer finds a described node.
  std::string first_name_of(const std::string& node) const { return name_in_scene(targets_.front(), node); }
  void log_result(const std::function<void(const std::string&)>& log) const;

 private:
  struct Target {
    std::string uri;
    Stream stream;
    bool has_robot = false;         // added to it
    bool is_robot_refused = false;  // it cannot be added
    std::string warning;            // not reported yet
    uint32_t renderers = 0;
    uint64_t frames_published = 0;
    std::string message, reported;  // of the renderer: newest, last reported
    std::chrono::steady_clock::time_point message_since;
  };
  std::string name_in_scene(const Target& target, const std::string& node) const;
  Result<void> add_robot(Target& target);
  // Adds or replaces the robot of this target.
  Result<void> offer_robot(Target& target);
  void drop_robot(Target& target, const std::string& reason);
  Result<void> describe(Target& target);
  Result<void> describe_or_drop_robot(Target& target);
  Result<void> repeat_frame(Target& target);

  std::vector<Target> targets_;
  size_t scene_budget_bytes_ = kSceneBudgetBytes;
  std::vector<uint8_t> robot_;                                // empty: none
  std::unordered_map<std::string, std::string> robot_paths_;  // nodes of the added robot, by name
  std::vector<std::string> names_;
  std::vector<Pose> offsets_, last_poses_;
  std::optional<int64_t> last_time_ns_;
  bool is_described_ = false;
};

}  // namespace fire3dv::ros2
