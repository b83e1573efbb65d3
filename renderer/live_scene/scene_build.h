// Background build of the merged scene: the file's scene with the nodes and assets that streams add. It runs
// in turns on a thread of its own, peers take turns by build time, and what each peer adds is charged to its
// budget.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/peer_budget.h"
#include "renderer/live_scene/asset_files.h"
#include "renderer/live_scene/peer_charges.h"
#include "renderer/live_scene/scene_build_names.h"
#include "renderer/scene/derived/copy_nodes.h"
#include "renderer/scene/derived/loaded_scene.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/scene.h"
#include "renderer/state/edits/edit_registry.h"
#include "renderer/state/node_index.h"

namespace fire3dv::app {

struct AssetSettings {
  std::filesystem::path folder = {};  // root of the assets that streams may name; empty: no files are read
  scene::Levels levels = scene::Levels::automatic_levels;
  uint32_t max_textures = UINT32_MAX;  // limit of the whole scene
  std::filesystem::path overlay = {};  // file of the user's additions, for messages and their assets
  uint64_t max_added_bytes = uint64_t{4} << 30;  // in memory, of all assets and copies together
  // Replaced by tests. Null: assets are loaded, and time is the monotonic clock.
  std::function<Result<scene::Scene>(const state::RequestedNode&, const scene::LoadLimits&)> load = {};
  std::function<int64_t()> now_ns = {};
};

class SceneBuild {
 public:
  struct VertexNode {
    std::string name;
    std::shared_ptr<PeerBudget> budget = nullptr;  // of the peer that replaces the vertices
  };
  struct Request {
    std::vector<state::RequestedNode> nodes;  // in any order of parents and children
    std::vector<VertexNode> vertex_nodes;     // nodes whose vertices will be replaced
    // A turn loads assets of one peer for this long at most, and one asset at least.
    int64_t turn_ns = 100'000'000;
    // Nodes of some peers are left out for now: nodes without a parent may wait for one of these.
    bool is_partial = false;
  };
  struct Refused {
    state::RequestedNode node;
    std::string reason;
  };
  struct Built {
    std::unique_ptr<const scene::LoadedScene> scene;  // null: the file's own
    std::vector<state::RequestedNode> added;
    std::vector<uint32_t> roots;  // of each added node: its index in the scene
    // Of copies by the user, by root: the nodes of which the root and those that follow it are copies.
    std::map<uint32_t, std::vector<uint32_t>> sources;
    std::map<uint32_t, MergedAsset> assets;        // by root; those of streams may have no file
    std::vector<state::RequestedNode> waiting;     // neither added nor refused: for assets or parents
    std::map<const PeerBudget*, int64_t> load_ns;  // time that loads took
    std::vector<Refused> refused;
    std::vector<std::string> vertex_nodes;               // as requested
    std::map<std::string, std::string> vertex_refusals;  // reasons of nodes that share the file's vertices
    std::vector<std::string> asset_warnings;             // of the loads, with the names of the assets
    bool assets_wait = false;  // some nodes are left out until their assets are loaded
    std::string fault;         // not empty: no scene could be made of `added`
    int64_t merge_ns = 0;      // time that the merge took, without loads
    uint64_t parent_lookups = 0;
  };

  // base: outlives this, or its use here ends with set_base().
  SceneBuild(const scene::LoadedScene& base, AssetSettings settings);

  // When idle: builds on another scene of the file from now on.
  void set_base(const scene::LoadedScene& base);
  // The same with another version of the file: assets whose files have changed are loaded again.
  void reload(const scene::LoadedScene& base);

  bool idle() const { return !thread_.joinable(); }
  void begin(Request request);  // when idle
  bool is_finished() const { return !idle() && finished_; }
  // Returns a finished build once; nullopt: none. Never waits.
  std::optional<Built> take();
  // When idle: releases all assets and charges except those of these nodes.
  void retain_only(std::span<const state::RequestedNode> nodes);
  // When idle: releases the charges of replaced vertices except those of these nodes, by sorted name.
  void retain_vertices_only(std::span<const std::string> nodes);

 private:
  struct Asset {
    scene::LoadedScene loaded;
    AssetSize size;
    ReadFiles files;
  };
  // Of an asset of the user: it is not loaded again before its files change.
  struct Failure {
    ReadFiles files;
    std::string reason;
  };
  using NodeKey = std::pair<uint64_t, uint64_t>;             // age and version
  using UseKey = std::pair<std::string, const PeerBudget*>;  // of an asset by a peer
  struct Merge;

  Built build(Request request, const std::stop_token& stop);
  void load_assets(const Request& request, const std::stop_token& stop, Merge& merge, Built& built);
  Result<std::shared_ptr<const Asset>> load(const state::RequestedNode& node, const std::stop_token& stop,
                                            BudgetCharge& charge, ReadFiles& files) const;
  Result<scene::Scene> load_scene(const state::RequestedNode& node, const scene::LoadLimits& limits,
                                  ReadFiles& files) const;
  void merge_nodes(Request& request, const std::stop_token& stop, Merge& merge, Built& built);
  // source: of a copy; kNone: the node is none.
  Result<void> add(const state::RequestedNode& node, uint32_t parent, uint32_t source, Merge& merge);
  Result<scene::CopyPlan> plan_copy(uint32_t source, Merge& merge) const;
  std::string too_many_bytes() const;
  void give_own_vertices(const Request& request, Merge& merge, Built& built);

  const scene::LoadedScene* base_;
  const AssetSettings settings_;
  // Owned by the thread while it runs.
  AssetFiles asset_files_;
  std::optional<state::NodeNames> base_names_;
  uint64_t base_path_bytes_ = 0;
  std::map<std::string, std::shared_ptr<const Asset>> assets_;  // loaded assets, by AssetFiles::key()
  std::map<std::string, Failure> failures_;                     // by the same keys
  std::map<UseKey, BudgetCharge> uses_;                         // decoded assets, once for each peer
  std::map<NodeKey, NodeCharges> node_charges_;
  std::map<UseKey, BudgetCharge> vertex_charges_;  // by node name
  BuildTurns turns_;
  Built built_;
  std::atomic<bool> finished_ = false;
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace fire3dv::app
