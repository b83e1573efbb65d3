// The file's scene with what streams have added to it, made on a thread of its own while the picture goes on.
#pragma once

#include <atomic>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "renderer/scene/scene_file.h"
#include "renderer/state/edit_book.h"

namespace fire3dv::app {

struct AssetSettings {
  std::filesystem::path folder;  // below which streams may name assets; empty: none is read from files
  scene::Levels levels = scene::Levels::where_they_pay;
  uint32_t most_textures = UINT32_MAX;  // of the whole scene
};

class SceneBuild {
 public:
  struct Request {
    std::vector<state::WantedNode> nodes;  // those before others may be their parents, or the other way round
    std::vector<std::string> vertex_nodes;  // whose vertices will be replaced
  };
  struct Refused {
    state::WantedNode node;
    std::string reason;
  };
  struct Built {
    std::unique_ptr<const scene::LoadedScene> scene;  // null: the file's own
    std::vector<state::WantedNode> added;
    std::vector<Refused> refused;
    std::vector<std::string> vertex_nodes;  // as requested
  };

  // base: outlives this.
  SceneBuild(const scene::LoadedScene& base, AssetSettings settings)
      : base_(base), settings_(std::move(settings)) {}

  bool idle() const { return !thread_.joinable(); }
  void begin(Request request);  // when idle
  // Once, when it is finished. Never waits.
  std::optional<Built> take();

 private:
  using Asset = std::shared_ptr<const scene::LoadedScene>;
  Built build(Request request);
  Result<Asset> asset_of(const state::WantedNode& node);
  Result<Asset> load(const state::WantedNode& node) const;
  Result<void> add(scene::LoadedScene& to, const state::WantedNode& node, uint32_t parent);

  const scene::LoadedScene& base_;
  const AssetSettings settings_;
  // Of the thread, while it runs: assets that are shown, by URI, or by stream and edit.
  std::map<std::string, Asset> assets_, last_assets_;
  uint64_t added_bytes_ = 0;
  Built built_;
  std::atomic<bool> finished_ = false;
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace fire3dv::app
