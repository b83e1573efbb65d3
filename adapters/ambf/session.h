// AMBF-independent half of the plugin: options, description, edits and publishing of one run. Callers acquire
// a turn, set poses and publish. A turn that another thread holds is skipped, so that no AMBF thread ever
// waits.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "adapters/ambf/end_signals.h"
#include "adapters/ambf/links.h"
#include "adapters/ambf/nodes.h"
#include "adapters/ambf/soft_mesh.h"

namespace fire3dv::ambf {

// Rate limiter that selects physics steps to publish. Periods count from due times, so that step size does
// not lower the mean rate. Missed frames are not made up for.
class RateLimit {
 public:
  explicit RateLimit(double rate_hz = 0)
      : period_ns_(rate_hz > 0 ? static_cast<int64_t>(1e9 / rate_hz) : 0) {}

  bool due(int64_t now_ns) {
    if (period_ns_ == 0) return true;
    if (started_ && now_ns < next_ns_) return false;
    next_ns_ = started_ && now_ns - next_ns_ < period_ns_ ? next_ns_ + period_ns_ : now_ns + period_ns_;
    started_ = true;
    return true;
  }

 private:
  int64_t period_ns_ = 0;  // 0: every step
  int64_t next_ns_ = 0;
  bool started_ = false;
};

class Session {
 public:
  // arguments: AMBF's argv. headless: AMBF creates no cameras, so they are read from its files. On error AMBF
  // continues without the plugin.
  static Result<std::unique_ptr<Session>> start(const std::vector<std::string>& arguments,
                                                const std::filesystem::path& ambf_root, bool headless);
  Session(Options options, CameraDefinitions cameras, Links links);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  // Returns true when a frame is due; the caller then holds the turn until end_turn.
  bool begin_turn(int64_t now_ns);
  void end_turn() { turn_.unlock(); }

  // Functions for use within a turn.
  // Replaces the object list, into which indices below point, and starts a new description.
  void describe(std::vector<Object> objects);
  void set_pose(size_t object, const Transform& world_from_object) {
    world_from_object_[object] = world_from_object;
  }
  void set_shown(size_t object, bool shown);
  void set_intrinsics(size_t object, const Intrinsics& intrinsics);
  // Current soft bodies, and whether this frame includes their vertices.
  Options::Names names() const { return options_.names; }
  void set_soft_bodies(const std::vector<SoftMesh>& meshes);
  bool vertices_due(int64_t now_ns) { return vertex_rate_.due(now_ns); }
  // False: the soft body was skipped and has no vertices.
  bool has_soft_body(size_t soft_body) const { return !soft_bodies_[soft_body].empty(); }
  void set_vertices(size_t soft_body, const std::vector<float>& positions);
  void publish(double sim_time_s, int64_t now_ns);

  // Marks the next frame as a discontinuity. Any thread.
  void jump();
  // Ends the streams in order. Waits for another thread's turn to end.
  void close();

 private:
  struct Sent {
    bool shown = true;  // scene files show every object
    bool gone = false;
    std::optional<Intrinsics> intrinsics;
    bool pose_refused = false;
  };
  void show(const std::string& name, Sent& sent, bool shown);
  void hide_removed();
  std::vector<size_t> order_added() const;
  void place_cameras();
  void gather_poses();

  const Options options_;
  const std::vector<CameraDefinition> cameras_;  // cameras read from files
  const std::vector<Listed> listed_;
  Links links_;
  RateLimit rate_, vertex_rate_;

  std::mutex turn_;
  bool closed_ = false;
  std::atomic<bool> jumped_{false};
  std::vector<Object> objects_;  // AMBF's objects, followed by cameras from files
  NodeTable nodes_;
  std::vector<Transform> world_from_object_;
  std::vector<std::optional<size_t>> camera_parents_;
  size_t first_camera_ = 0;  // index in objects_ of the first camera from files
  // Edits by node name, since they outlive descriptions.
  std::map<std::string, Sent> sent_;
  std::vector<Sent*> sent_of_;  // by object; null: skipped
  std::vector<float> poses_;
  std::vector<std::string> soft_bodies_;  // names; empty: skipped
  std::set<std::string> removed_;         // soft bodies of the scene file that were removed
  int64_t polled_at_ns_ = 0, reported_at_ns_ = 0;
  std::unique_ptr<EndSignals> signals_;  // last, since its thread uses all members above
};

}  // namespace fire3dv::ambf
