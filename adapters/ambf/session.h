// What the plugin does in a run of AMBF, without AMBF: the file that knows AMBF asks for a turn, gives poses
// and what else is to be seen, and publishes. A turn that cannot be had at once is none, so no thread of AMBF
// ever waits.
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

#include "adapters/ambf/camera_file.h"
#include "adapters/ambf/end_signals.h"
#include "adapters/ambf/links.h"
#include "adapters/ambf/node_table.h"
#include "adapters/ambf/rate_limit.h"
#include "adapters/ambf/soft_mesh.h"
#include "adapters/ambf/transform.h"

namespace fire3dv::ambf {

class Session {
 public:
  // arguments: AMBF's own. headless: AMBF makes no cameras, so they are read from its files. The error is for
  // people; AMBF goes on without the plugin.
  static Result<std::unique_ptr<Session>> start(const std::vector<std::string>& arguments,
                                                const std::filesystem::path& ambf_root, bool headless);
  Session(Options options, CameraDefinitions cameras, Links links);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  // True: a frame is due and the caller's alone until end_turn. Else nothing is held and nothing is to be
  // done.
  bool begin_turn(int64_t now_ns);
  void end_turn() { turn_.unlock(); }

  // Within a turn:
  // Objects are other ones than before; indices below are into this list. Starts a new description.
  void describe(std::vector<Object> objects);
  void set_pose(size_t object, const Transform& world_from_object) {
    world_from_object_[object] = world_from_object;
  }
  void set_shown(size_t object, bool shown);
  void set_intrinsics(size_t object, const Intrinsics& intrinsics);
  // Soft bodies that there are now, and whether their vertices are wanted in this frame.
  Options::Names names() const { return options_.names; }
  void set_soft_bodies(const std::vector<SoftMesh>& meshes);
  bool vertices_due(int64_t now_ns) { return vertex_rate_.due(now_ns); }
  // One that was left out has no vertices.
  bool has_soft_body(size_t soft_body) const { return !soft_bodies_[soft_body].empty(); }
  void set_vertices(size_t soft_body, const std::vector<float>& positions);
  void publish(double sim_time_s, int64_t now_ns);

  // Any thread. The next frame is not a continuation of the last.
  void jump();
  // Ends the streams in order; waits for a turn of another thread to end.
  void close();

 private:
  struct Sent {
    bool shown = true;  // files show what they have
    bool gone = false;
    std::optional<Intrinsics> intrinsics;
    bool pose_refused = false;
  };
  void show(const std::string& name, Sent& sent, bool shown);
  void hide_what_is_gone();
  std::vector<size_t> order_added() const;
  void place_cameras();
  void gather_poses();

  const Options options_;
  const std::vector<CameraDefinition> cameras_;  // of files
  const std::vector<Listed> listed_;
  Links links_;
  RateLimit rate_, vertex_rate_;

  std::mutex turn_;
  bool closed_ = false;
  std::atomic<bool> jumped_{false};
  std::vector<Object> objects_;  // with the files' cameras behind them
  NodeTable nodes_;
  std::vector<Transform> world_from_object_;
  std::vector<std::optional<size_t>> camera_parents_;
  size_t first_camera_ = 0;  // of the files', among objects_
  // Edits outlive descriptions in streams, so they are remembered by name.
  std::map<std::string, Sent> sent_;
  std::vector<Sent*> sent_of_;  // by object; none: it is left out
  std::vector<float> poses_;
  std::vector<std::string> soft_bodies_;  // names; empty: it was left out
  std::set<std::string> removed_;         // files' soft bodies
  int64_t polled_at_ns_ = 0, told_at_ns_ = 0;
  std::unique_ptr<EndSignals> signals_;  // last: its thread uses all of the above
};

}  // namespace fire3dv::ambf
