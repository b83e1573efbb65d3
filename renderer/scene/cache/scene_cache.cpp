#include "renderer/scene/cache/scene_cache.h"

#include <system_error>

#include "renderer/scene/cache/cache_files.h"

namespace fire3dv::scene {
namespace {

using Place = SceneCacheSettings::Place;
constexpr std::string_view kEnding = ".scene", kEndingBeside = ".fire3dv-cache";

// True if all files but the asset's own are unchanged.
bool others_are_the_same(const std::filesystem::path& asset, const std::vector<SourceFile>& sources,
                         uint64_t max_file_bytes, DigestCache& known) {
  const AssetFolder folder(asset);
  for (size_t i = 1; i < sources.size(); ++i) {
    const auto path = folder.resolve(sources[i].uri);
    if (!path) return false;
    const auto held = known.of(*path, max_file_bytes);
    if (!held || held->digest != sources[i].digest) return false;
  }
  return true;
}

bool same(const std::vector<SourceFile>& a, const std::vector<SourceFile>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const SourceFile& x, const SourceFile& y) {
    return x.uri == y.uri && x.digest == y.digest;
  });
}

}  // namespace

std::filesystem::path SceneCache::place_of(const std::filesystem::path& asset, const Digest& own) const {
  if (settings_.place == Place::beside_the_asset) return asset.string() + std::string(kEndingBeside);
  // The name has half of the digest; the entry contains the whole one.
  return settings_.folder / (hex(std::span(own).first(16)) + std::string(kEnding));
}

std::optional<LoadedScene> SceneCache::find(const std::filesystem::path& asset, uint64_t max_file_bytes) {
  if (settings_.place == Place::nowhere) return std::nullopt;
  if (settings_.place == Place::folder) digests_ = DigestCache(settings_.folder, asset);
  const auto stamped = digests_.of(asset, max_file_bytes);
  if (!stamped) return std::nullopt;  // the loader reports the error
  known_ = *stamped;
  const Digest& own = known_->digest;
  const std::filesystem::path path = place_of(asset, own);
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::nullopt;
  const auto unusable = [&](const std::string& why) {
    notes_.push_back("cache: " + quote(path.string()) + " is rebuilt: " + why);
    return std::nullopt;
  };
  const auto sources = read_scene_sources(path);
  if (!sources) return unusable(sources.error().message);
  const bool own_is_the_same =
      !sources->empty() && sources->front().uri.empty() && sources->front().digest == own;
  if (!own_is_the_same || !others_are_the_same(asset, *sources, max_file_bytes, digests_))
    return unusable("files of the scene have changed");
  auto cached = read_scene_file(path);
  if (!cached) return unusable(cached.error().message);
  if (!same(cached->sources, *sources)) return unusable("it changed while it was read");
  touch(path);
  digests_.store();
  cached->loaded.scene.source = asset;
  return std::move(cached->loaded);
}

Result<void> SceneCache::store(const std::filesystem::path& asset, const LoadedScene& loaded,
                               const std::vector<SourceFile>& sources) {
  if (settings_.place == Place::nowhere || sources.empty()) return {};
  const uint64_t bytes = array_bytes(loaded);
  if (bytes < settings_.least_scene_bytes) return {};
  if (settings_.place == Place::beside_the_asset) {
    return write_scene_file(place_of(asset, sources.front().digest), loaded, sources);
  }
  if (bytes > settings_.most_bytes) return {};
  std::error_code error;
  std::filesystem::create_directories(settings_.folder, error);
  if (error)
    return Error{"cannot make the folder " + quote(settings_.folder.string()) + ": " + error.message()};
  auto written = write_scene_file(place_of(asset, sources.front().digest), loaded, sources);
  remove_oldest(settings_.folder, kEnding, settings_.most_bytes);
  if (written) digests_.store();
  return written;
}

}  // namespace fire3dv::scene
