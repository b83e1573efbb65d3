// Edited scene of a fuzzed session: base scene, edits and simulated background builds.
#include "tests/fuzz/session_scene.h"

#include <algorithm>
#include <chrono>
#include <span>
#include <thread>

#include "base/error.h"
#include "base/glb.h"
#include "renderer/scene/gltf/load_gltf.h"

namespace fire3dv::fuzz {
namespace {

std::vector<std::pair<uint64_t, uint64_t>> keys_of(const std::vector<state::RequestedNode>& nodes) {
  std::vector<std::pair<uint64_t, uint64_t>> keys;
  for (const state::RequestedNode& node : nodes) keys.emplace_back(node.age, node.version);
  std::sort(keys.begin(), keys.end());
  return keys;
}

}  // namespace

std::vector<std::byte> small_glb() {
  const std::string json = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,5]}],"nodes":[
    {"name":"root","children":[1,2,3]},{"name":"body","mesh":0},{"name":"left","children":[4]},
    {"name":"twin","mesh":0},{"name":"twin"},{"name":"camera","camera":0}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":0.1}}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
    "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36}]})";
  const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  return base::make_glb(json, std::as_bytes(std::span(corners)));
}

const scene::LoadedScene& base_scene() {
  static const scene::LoadedScene base = [] {
    auto loaded = scene::load_glb(small_glb(), "the base scene");
    FIRE3DV_ASSERT(loaded.ok());
    scene::Derived derived = scene::derive(*loaded);
    return scene::LoadedScene{std::move(*loaded), std::move(derived)};
  }();
  return base;
}

SessionScene::SessionScene(state::PoseState& poses) : poses_(poses), build_(base_scene(), {}) {
  poses.load_assets_asynchronously();
}

bool SessionScene::follow(bool finish_build) {
  if (!build_.idle() && finish_build) {
    std::optional<app::SceneBuild::Built> built;
    while (!(built = build_.take())) std::this_thread::sleep_for(std::chrono::microseconds(20));
    show_built(std::move(*built));
  }
  std::vector<state::SceneChanges> changes = poses_.take_scene_changes();
  note_hiding(changes);
  registry_.apply(std::move(changes), &poses_.names());
  std::vector<state::RequestedNode> wanted = registry_.requested_nodes();
  resolve(wanted);
  const std::vector<std::string> vertex_nodes(registry_.vertex_nodes().begin(),
                                              registry_.vertex_nodes().end());
  const bool is_new = keys_of(wanted) != nodes_ || vertex_nodes != vertex_nodes_;
  if (build_.idle() && is_new)
    begin_build(std::move(wanted), vertex_nodes);
  else if (build_.idle())
    build_.retain_only(wanted);  // as LiveScene does
  bool shown = false;
  for (const state::EditRegistry::Finished& edit : registry_.take_finished())
    shown |= poses_.finish_edit(edit.stream, edit.epoch, edit.version);
  (void)registry_.take_log_messages();
  return shown;
}

void SessionScene::begin_build(std::vector<state::RequestedNode> wanted,
                               const std::vector<std::string>& vertex_nodes) {
  app::SceneBuild::Request request;
  request.nodes = std::move(wanted);
  for (const std::string& name : vertex_nodes) request.vertex_nodes.push_back({name});
  build_.begin(std::move(request));
}

void SessionScene::resolve(const std::vector<state::RequestedNode>& wanted) {
  scene::NodeEdits edits = registry_.resolve(scene(), poses_, keys_of(wanted) == nodes_);
  hidden_.clear();
  for (const auto& [node, edit] : edits) {
    FIRE3DV_ASSERT(node < scene().nodes.size());
    if (edit.hidden || edit.removed) hidden_.insert(node);
  }
  for (const state::RequestedNode& node : added_) {
    const bool stays = std::any_of(wanted.begin(), wanted.end(), [&](const state::RequestedNode& other) {
      return other.age == node.age && other.version == node.version;
    });
    const uint32_t index = stays ? scene::kNone : poses_.names().find(node.name);
    if (index == scene::kNone) continue;
    edits[index].removed = true;
    hidden_.erase(index);
  }
  edits_.set(scene(), std::move(edits));
}

bool SessionScene::show_built(app::SceneBuild::Built&& built) {
  for (const app::SceneBuild::Refused& refused : built.refused)
    registry_.refuse_node(refused.node, refused.reason);
  if (!built.fault.empty()) {
    for (const state::RequestedNode& node : built.added) registry_.refuse_node(node, built.fault);
    build_.retain_only(added_);
    registry_.set_built_vertex_nodes(vertex_nodes_);
    return true;
  }
  for (const state::RequestedNode& node : built.added) registry_.confirm_node(node);
  nodes_ = keys_of(built.added);
  added_ = std::move(built.added);
  vertex_nodes_ = std::move(built.vertex_nodes);
  registry_.set_built_vertex_nodes(vertex_nodes_);
  if (!built.scene && !merged_) return true;
  const std::unique_ptr<const scene::LoadedScene> before = std::exchange(merged_, std::move(built.scene));
  poses_.set_scene(scene());
  return true;
}

void SessionScene::note_hiding(const std::vector<state::SceneChanges>& changes) {
  for (const state::SceneChanges& change : changes) {
    if (change.ended) {
      hiding_.erase(change.age);
      continue;
    }
    for (const wire::SceneEdit& edit : change.edits) {
      const auto* visible = std::get_if<wire::Visible>(&edit.value);
      hiding_[change.age][{edit.node, edit.property}] =
          (visible && !visible->visible) || std::holds_alternative<wire::NodeRemoved>(edit.value);
    }
  }
}

// Nodes may share a path; an edit stays with the node that had the path when it was bound.
std::optional<uint64_t> SessionScene::oldest_hider(uint32_t node) const {
  for (const auto& [age, keys] : hiding_)
    for (const auto& [key, hides] : keys)
      if (hides && (poses_.names().find(key.first) == node || scene().nodes[node].path == key.first))
        return age;
  return std::nullopt;
}

}  // namespace fire3dv::fuzz
