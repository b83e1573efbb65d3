#include "renderer/app/scene_build.h"

#include <algorithm>
#include <exception>
#include <new>

#include "renderer/scene/bounds.h"
#include "renderer/scene/deformed_copies.h"
#include "renderer/scene/math.h"
#include "renderer/scene/merge_scenes.h"
#include "renderer/scene/replaced_vertices.h"
#include "renderer/state/bindings.h"

namespace fire3dv::app {
namespace {

// Tighter than for the file that the user has named: assets come from whoever may publish.
scene::LoadLimits asset_limits() {
  scene::LoadLimits limits;
  limits.max_file_bytes = uint64_t{1} << 30;
  limits.max_image_pixels = uint64_t{1} << 26;  // of all images of an asset
  limits.max_elements = uint64_t{1} << 26;
  return limits;
}
constexpr uint64_t kMostAddedBytes = uint64_t{4} << 30;  // in memory, of all assets together

std::string asset_key(const state::WantedNode& node) {
  if (!node.what->asset_uri.empty()) return "uri " + node.what->asset_uri;
  return "edit " + std::to_string(node.age) + " " + std::to_string(node.version);
}

}  // namespace

void SceneBuild::begin(Request request) {
  finished_ = false;
  thread_ = std::jthread([this, request = std::move(request)]() mutable {
    built_ = {};
    const std::vector<state::WantedNode> nodes = request.nodes;
    const std::vector<std::string> vertex_nodes = request.vertex_nodes;
    std::string fault;
    try {
      built_ = build(std::move(request));
    } catch (const std::bad_alloc&) {
      fault = "the scene with it does not fit into memory";
    } catch (const std::exception& error) {
      fault = std::string("the scene with it cannot be made: ") + error.what();
    }
    if (!fault.empty()) {
      built_ = {};
      built_.vertex_nodes = vertex_nodes;
      for (const state::WantedNode& node : nodes) built_.refused.push_back({node, fault});
    }
    finished_ = true;
  });
}

std::optional<SceneBuild::Built> SceneBuild::take() {
  if (idle() || !finished_) return std::nullopt;
  thread_.join();
  thread_ = {};
  return std::exchange(built_, {});
}

// Parents may be among what is added; so nodes are asked until none finds its parent any more.
SceneBuild::Built SceneBuild::build(Request request) {
  Built built;
  built.vertex_nodes = std::move(request.vertex_nodes);
  last_assets_ = std::exchange(assets_, {});
  added_bytes_ = 0;
  if (request.nodes.empty() && built.vertex_nodes.empty()) return built;
  auto merged = std::make_unique<scene::LoadedScene>(base_);
  std::vector<state::WantedNode> open = std::move(request.nodes);
  for (bool progress = true; progress && !open.empty();) {
    progress = false;
    const state::NodeNames names(merged->scene);
    for (state::WantedNode& node : std::exchange(open, {})) {
      const std::string& parent_name = node.what->parent;
      const uint32_t parent = parent_name.empty() ? scene::kNone : names.find(parent_name);
      if (parent == scene::kNone && !parent_name.empty()) {
        open.push_back(std::move(node));
        continue;
      }
      progress = true;
      // Of one round two may ask for the same name: the first one is in the scene by now.
      const bool taken =
          std::any_of(built.added.begin(), built.added.end(),
                      [&](const state::WantedNode& other) { return other.name == node.name; }) ||
          names.find(node.name) != scene::kNone;
      const Result<void> done =
          taken ? Result<void>(Error{"there is a node of that name already"}) : add(*merged, node, parent);
      if (done)
        built.added.push_back(std::move(node));
      else
        built.refused.push_back({std::move(node), done.error().message});
    }
  }
  for (state::WantedNode& node : open) {
    std::string reason = "no node is called " + scene::quote(node.what->parent) + ", its parent";
    built.refused.push_back({std::move(node), std::move(reason)});
  }
  const state::NodeNames names(merged->scene);
  for (const std::string& name : built.vertex_nodes) {
    const uint32_t node = names.find(name);
    if (node == scene::kNone || !scene::takes_vertices(merged->scene.nodes[node])) continue;
    merged->scene.nodes[node].own_vertices = true;
    // Too many to have copies of: vertices stay as they are.
    if (!scene::check_deformed_copies(merged->scene)) merged->scene.nodes[node].own_vertices = false;
  }
  scene::find_world_bounds(merged->scene);
  built.scene = std::move(merged);
  last_assets_.clear();
  return built;
}

Result<void> SceneBuild::add(scene::LoadedScene& to, const state::WantedNode& node, uint32_t parent) {
  Result<Asset> asset = asset_of(node);
  if (!asset) return asset.error();
  const glm::mat4 parent_from_node = scene::to_mat4(node.what->parent_from_node);
  if (!*asset) {
    scene::add_node(to.scene, node.name, parent, parent_from_node);
    return {};
  }
  added_bytes_ += scene::array_bytes(**asset);
  if (added_bytes_ > kMostAddedBytes)
    return Error{"all assets together take more than " + std::to_string(kMostAddedBytes >> 20) + " MiB"};
  if (to.scene.textures.size() + (*asset)->scene.textures.size() > settings_.most_textures)
    return Error{"the scene would have more than " + std::to_string(settings_.most_textures) + " textures"};
  const uint32_t root = scene::add_node(to.scene, node.name, parent, parent_from_node);
  Result<void> done = scene::add_below(to, **asset, root);
  if (!done) to.scene.nodes.pop_back();
  return done;
}

// Null: the node is empty.
Result<SceneBuild::Asset> SceneBuild::asset_of(const state::WantedNode& node) {
  if (node.what->asset_uri.empty() && node.what->asset_glb.empty()) return Asset();
  const std::string key = asset_key(node);
  if (const auto known = assets_.find(key); known != assets_.end()) return known->second;
  if (const auto known = last_assets_.find(key); known != last_assets_.end())
    return assets_[key] = known->second;
  Result<Asset> loaded = load(node);
  if (loaded) assets_[key] = *loaded;
  return loaded;
}

Result<SceneBuild::Asset> SceneBuild::load(const state::WantedNode& node) const {
  const std::string& uri = node.what->asset_uri;
  Result<scene::Scene> scene = Error{""};
  if (uri.empty()) {
    scene = scene::load_glb(node.what->asset_glb, "the embedded asset", asset_limits());
  } else {
    const std::string name = "the asset " + scene::quote(uri);
    if (settings_.folder.empty())
      return Error{name + " is a file, and no folder was named for such (--assets DIR)"};
    // Named from within the folder, as a file there would name it.
    const Result<std::filesystem::path> path = scene::AssetFolder(settings_.folder / "scene").resolve(uri);
    if (!path) return path.error();
    scene = scene::load_gltf(*path, asset_limits());
  }
  if (!scene) return scene.error();
  scene::Derived derived = scene::derive(*scene, settings_.levels);
  return Asset(
      std::make_shared<const scene::LoadedScene>(scene::LoadedScene{std::move(*scene), std::move(derived)}));
}

}  // namespace fire3dv::app
