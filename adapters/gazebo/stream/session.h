// Session of fire3dv-gazebo: finds the world, follows its scene and poses, and keeps renderers up to date.
// The Gazebo server and renderers may come, go and come back in any order.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "adapters/gazebo/stream/assets.h"
#include "adapters/gazebo/stream/cameras.h"
#include "adapters/gazebo/stream/publisher.h"
#include "adapters/gazebo/wire/node.h"
#include "adapters/gazebo/world/world.h"

namespace fire3dv::gazebo {

struct SessionOptions {
  std::string world;                  // empty: the only one
  std::filesystem::path write_scene;  // empty: none
  bool add_scene = false;             // renderers get the whole scene over the stream
  bool ends_after_scene = false;      // once it is written
  CameraChoice cameras;
};

class Session {
 public:
  // resource_folders: as of scene_model().
  using Log = std::function<void(const std::string& line)>;
  Session(std::unique_ptr<Node> node, Publisher publisher,
          std::vector<std::filesystem::path> resource_folders, SessionOptions options, Log log);

  // Returns when stop is set, or with an error that waiting does not mend.
  Result<void> run(const std::atomic<bool>& stop);
  void log_totals();

 private:
  Result<void> find_world(int64_t now_ns);
  // True once for each version of the directory, whose lists are copied to be searched.
  bool has_news(std::optional<uint64_t>& searched) const;
  void find_server();
  void lose_server(const std::vector<std::string>& ended);
  void follow_topics();
  void request_scene(int64_t now_ns);
  Result<void> receive_scene();
  Result<void> first_scene();
  Result<void> apply(World::Changes changes);
  Result<void> receive_messages();
  Result<void> receive_poses(const Message& message, PoseTopic topic);
  Result<void> receive_assets();
  Result<void> describe();
  Result<void> publish();
  void report(const std::vector<std::string>& warnings);
  std::string scene_node() const { return "world " + world_name_; }  // root of --add-scene
  std::string topic(const char* name) const { return "/world/" + world_name_ + "/" + name; }

  std::unique_ptr<Node> node_;
  Publisher publisher_;
  const std::vector<std::filesystem::path> resource_folders_;
  const SessionOptions options_;
  const Log log_;
  World world_;
  AssetQueue assets_;
  Cameras cameras_;
  std::string world_name_;
  std::optional<Advertisement> server_;  // its scene/info service
  bool has_scene_ = false, is_done_ = false, has_reported_missing_ = false, has_reported_waiting_ = false;
  bool has_reported_refused_ = false;
  bool needs_scene_ = true, needs_describe_ = false, needs_frame_ = false, is_jump_ = true;
  uint64_t scene_request_ = 0, failed_requests_ = 0, next_added_ = 1, reported_invalid_ = 0;
  int64_t begun_ns_ = 0, next_request_ns_ = 0, sim_time_ns_ = 0;
  std::vector<float> poses_;
  std::optional<int64_t> world_seen_ns_;  // the first one, of any name
  // Versions of the directory that were searched; empty: none.
  std::optional<uint64_t> searched_for_world_, chosen_from_, searched_for_server_, searched_for_topics_;
};

}  // namespace fire3dv::gazebo
