#include "renderer/app/options/overlay_options.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include "renderer/editing/overlay_file.h"

namespace fire3dv::app {
namespace {

bool overlay_exists(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::exists(std::filesystem::symlink_status(path, error));
}

}  // namespace

OverlayFile overlay_file(const Options& options, bool scene_is_file) {
  const std::string scene = options.scene.filename().string();
  const bool has_variant = !options.variant.empty();
  if (!options.overlay.empty())
    return {options.overlay, scene, true, has_variant, options.assets, digest_of_overlay(options.overlay)};
  if (!scene_is_file || scene.empty()) return {{}, scene, false, has_variant, options.assets};
  std::filesystem::path path = options.scene;
  path += ".overlay.json";
  return {std::move(path), scene, false, has_variant, options.assets};
}

Result<state::EditDocument> load_overlay(const Options& options) {
  const bool is_read = !options.overlay.empty() && (options.headless || overlay_exists(options.overlay));
  Result<state::EditDocument> document =
      is_read ? state::load_overlay(options.overlay) : Result<state::EditDocument>(state::EditDocument());
  if (document && !options.variant.empty()) (*document)[state::variant_key()] = options.variant;
  return document;
}

}  // namespace fire3dv::app
