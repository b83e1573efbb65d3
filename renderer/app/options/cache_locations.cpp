#include "renderer/app/options/cache_locations.h"

namespace fire3dv::app {
namespace {

using Place = scene::SceneCacheSettings::Place;

// The XDG specification requires that relative paths are ignored.
std::optional<std::filesystem::path> absolute(const char* value) {
  if (!value || *value != '/') return std::nullopt;
  return std::filesystem::path(value);
}

std::optional<std::filesystem::path> user_folder(const std::function<const char*(const char*)>& environment) {
  if (const auto cache = absolute(environment("XDG_CACHE_HOME"))) return *cache / "fire3dv";
  if (const auto home = absolute(environment("HOME"))) return *home / ".cache" / "fire3dv";
  return std::nullopt;
}

}  // namespace

CacheLocations find_cache_locations(std::string_view wanted,
                                    const std::function<const char*(const char*)>& environment) {
  CacheLocations places;
  if (wanted == "off") return places;
  const bool named = wanted != "auto" && wanted != "beside";
  const std::optional<std::filesystem::path> folder =
      named ? std::optional<std::filesystem::path>(wanted) : user_folder(environment);
  if (folder) {
    places.pipelines = *folder / "pipelines";
    places.environments = *folder / "environments";
    places.scenes.place = Place::folder;
    places.scenes.folder = *folder / "scenes";
  }
  if (wanted == "beside") places.scenes.place = Place::beside_the_asset;
  return places;
}

}  // namespace fire3dv::app
