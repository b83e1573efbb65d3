#include "renderer/live_scene/asset_files.h"

#include <algorithm>
#include <optional>

#include "base/text.h"

namespace fire3dv::app {

bool has_asset(const state::RequestedNode& node) {
  return !node.added->asset_uri.empty() || !node.added->asset_glb.empty();
}

std::string asset_name(const state::RequestedNode& node) {
  const std::string& uri = node.added->asset_uri;
  return uri.empty() ? std::string("the embedded asset") : "the asset " + quote(uri);
}

ReadFiles::ReadFiles(const std::filesystem::path& asset) : asset_(asset) {
  files_[asset] = scene::stamp_of(asset);
}

void ReadFiles::finish(const std::vector<scene::SourceFile>& sources) {
  const scene::AssetFolder folder(asset_);
  for (const scene::SourceFile& source : sources) {
    if (source.uri.empty()) {
      digest_ = source.digest;
      continue;
    }
    const Result<std::filesystem::path> file = folder.resolve(source.uri);
    lacks_file_ |= !file || source.digest == Digest{};
    if (file) files_.try_emplace(*file, scene::stamp_of(*file));
  }
}

bool ReadFiles::are_unchanged() const {
  return !lacks_file_ && std::ranges::all_of(files_, [](const auto& known) {
    return known.second.exists && scene::stamp_of(known.first) == known.second;
  });
}

Result<std::filesystem::path> AssetFiles::find(const std::string& uri, bool is_of_user) const {
  std::vector<std::filesystem::path> places;  // files, whose folders the URI is relative to
  if (is_of_user && !overlay_.empty()) places.push_back(overlay_);
  if (!folder_.empty()) places.push_back(folder_ / "scene");
  if (places.empty())
    return Error{"the asset " + quote(uri) + " is a file, and no folder was named for such (--assets DIR)"};
  std::optional<Error> fault;  // of the first folder
  for (const std::filesystem::path& place : places) {
    Result<std::filesystem::path> path = scene::AssetFolder(place).resolve(uri);
    if (path) return path;
    if (!fault) fault = path.error();
  }
  return *fault;
}

std::string AssetFiles::key(const state::RequestedNode& node) {
  const std::string& uri = node.added->asset_uri;
  if (uri.empty()) return "edit " + std::to_string(node.age) + " " + std::to_string(node.version);
  const std::string variant = "\n" + node.added->variant;  // a name has no line break
  if (!node.addition) return "uri " + uri + variant;
  const auto [path, is_new] = paths_.try_emplace(uri);
  if (is_new) {
    if (Result<std::filesystem::path> found = find(uri, true); found) path->second = std::move(*found);
  }
  return path->second.empty() ? "user's uri " + uri + variant
                              : "user's file " + path->second.string() + variant;
}

void AssetFiles::forget_missing() {
  std::erase_if(paths_, [](const auto& known) { return known.second.empty(); });
}

}  // namespace fire3dv::app
