#include "renderer/editing/asset_digest.h"

#include <filesystem>
#include <map>
#include <span>
#include <variant>

#include "base/digest.h"
#include "renderer/live_scene/peer_charges.h"
#include "renderer/scene/cache/scene_digest.h"
#include "renderer/scene/gltf/load_gltf.h"

namespace fire3dv::app {

std::string digest_of_assets(const state::EditDocument& document, const AssetFiles& files,
                             const std::function<bool()>& should_stop) {
  std::map<std::filesystem::path, std::string> known;  // by file
  std::string text;
  for (const auto& [key, value] : document) {
    const auto* const addition = std::get_if<state::Addition>(&value);
    const auto* const asset = addition ? std::get_if<state::AddedAsset>(&addition->content) : nullptr;
    if (!asset) continue;
    if (should_stop()) break;
    text += key.name + "\n";
    const Result<std::filesystem::path> path = files.find(asset->uri, true);
    if (!path) {
      text += path.error().message + "\n";
      continue;
    }
    const auto [entry, is_new] = known.try_emplace(*path);
    if (is_new) {
      BudgetCharge unlimited;
      scene::LoadLimits limits = limits_of_asset(nullptr, unlimited);
      limits.stop_requested = should_stop;
      const Result<scene::Scene> scene = scene::load_gltf(*path, limits);
      entry->second = scene ? scene::content_digest(*scene) : scene.error().message;
    }
    text += entry->second + "\n";
  }
  if (text.empty()) return text;
  return hex(digest_of(std::as_bytes(std::span(text)))).substr(0, 32);
}

}  // namespace fire3dv::app
