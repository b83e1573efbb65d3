#include "tests/fuzz/session_doubles.h"

#include <span>
#include <string>
#include <variant>

#include "base/glb.h"
#include "renderer/scene/gltf/load_gltf.h"

namespace fire3dv::fuzz {

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

Result<void> SessionUploader::check_memory(const scene::LoadedScene&) const {
  if (choices_ && choices_->one_in(12)) return Error{"the scene does not fit"};
  return {};
}

Result<void> SessionUploader::upload(const scene::LoadedScene& next) {
  FIRE3DV_ASSERT(next.scene.nodes.size() >= base_scene().scene.nodes.size());
  // The base scene fits by definition.
  if (choices_ && &next != &base_scene() && choices_->one_in(20)) return Error{"the device is out of memory"};
  return {};
}

void SessionUploader::set_markers(const std::vector<state::ShownMarker>& markers) {
  for (const state::ShownMarker& marker : markers) FIRE3DV_ASSERT(marker.marker != nullptr);
}

int64_t BuildGate::now_ns() {
  std::unique_lock lock(mutex_);
  if (std::this_thread::get_id() != owner_) opened_.wait(lock, [this] { return is_open_; });
  return now_ns_;
}

void BuildGate::set_open(bool is_open) {
  const std::lock_guard lock(mutex_);
  is_open_ = is_open;
  opened_.notify_all();
}

void BuildGate::advance(int64_t ns) {
  const std::lock_guard lock(mutex_);
  now_ns_ += ns;
}

void HidingEdits::add(const state::SceneChanges& change) {
  if (change.ended) {
    hiding_.erase(change.age);
    return;
  }
  for (const wire::SceneEdit& edit : change.edits) {
    const auto* visible = std::get_if<wire::Visible>(&edit.value);
    hiding_[change.age][{edit.node, edit.property}] =
        (visible && !visible->visible) || std::holds_alternative<wire::NodeRemoved>(edit.value);
  }
}

// Nodes may share a path; an edit stays with the node that had the path when it was bound.
std::optional<uint64_t> HidingEdits::oldest_hider(uint32_t node, const scene::Scene& scene,
                                                  const state::NodeNames& names) const {
  for (const auto& [age, keys] : hiding_)
    for (const auto& [key, hides] : keys)
      if (hides && (names.find(key.first) == node || scene.nodes[node].path == key.first)) return age;
  return std::nullopt;
}

}  // namespace fire3dv::fuzz
