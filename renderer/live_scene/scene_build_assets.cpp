// Loads of assets, and what a reload keeps of them.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "renderer/live_scene/scene_build.h"
#include "renderer/scene/derived/variants.h"

namespace fire3dv::app {

// Charges of changed assets are taken again: their files may have other nodes.
void SceneBuild::reload(const scene::LoadedScene& base) {
  set_base(base);
  failures_.clear();
  const size_t forgotten =
      std::erase_if(assets_, [](const auto& entry) { return !entry.second->files.are_unchanged(); });
  if (forgotten == 0) return;
  std::erase_if(uses_, [&](const auto& entry) { return !assets_.contains(entry.first.first); });
  node_charges_.clear();
}

Result<std::shared_ptr<const SceneBuild::Asset>> SceneBuild::load(const state::RequestedNode& node,
                                                                  const std::stop_token& stop,
                                                                  BudgetCharge& charge,
                                                                  ReadFiles& files) const {
  scene::LoadLimits limits = limits_of_asset(node.budget, charge);
  limits.stop_requested = [&stop] { return stop.stop_requested(); };
  Result<scene::Scene> scene =
      settings_.load ? settings_.load(node, limits) : load_scene(node, limits, files);
  if (!scene) return scene.error();
  if (stop.stop_requested()) return Error{"the load was stopped"};
  std::optional<uint32_t> variant;
  if (!node.added->variant.empty()) {
    const Result<uint32_t> found = scene::find_variant(*scene, node.added->variant);
    if (!found) return Error{asset_name(node) + ": " + found.error().message};
    variant = *found;
  }
  scene::Derived derived = scene::derive(*scene, settings_.levels);
  auto asset = std::make_shared<Asset>(Asset{{std::move(*scene), std::move(derived)}, {}, files});
  if (variant) scene::select_variant(asset->loaded, *variant);
  asset->size = measure(asset->loaded);
  // Replaces the loader's reservation by the size of the asset.
  if (Result<void> charged = charge.resize(asset->size.host_bytes); !charged) return charged.error();
  return std::shared_ptr<const Asset>(std::move(asset));
}

Result<scene::Scene> SceneBuild::load_scene(const state::RequestedNode& node, const scene::LoadLimits& limits,
                                            ReadFiles& files) const {
  const std::string& uri = node.added->asset_uri;
  if (uri.empty()) return scene::load_glb(node.added->asset_glb, asset_name(node), limits);
  const Result<std::filesystem::path> path = asset_files_.find(uri, node.addition != nullptr);
  if (!path) return path.error();
  files = ReadFiles(*path);
  std::vector<scene::SourceFile> sources;
  Result<scene::Scene> scene = scene::load_gltf(*path, limits, {}, &sources);
  files.finish(sources);
  return scene;
}

}  // namespace fire3dv::app
