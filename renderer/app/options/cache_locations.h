// Cache locations: loaded scenes, compiled pipelines and prefiltered environment maps.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "renderer/scene/cache/scene_cache.h"

namespace fire3dv::app {

struct CacheLocations {
  scene::SceneCacheSettings scenes;
  std::optional<std::filesystem::path> pipelines, environments;  // folders
};

// Resolves the value of --cache. "auto": the XDG cache folder, if the environment defines one; "beside":
// scenes next to their files; "off": no cache; otherwise a folder. environment: same interface as
// std::getenv.
CacheLocations find_cache_locations(std::string_view wanted,
                                    const std::function<const char*(const char*)>& environment);

}  // namespace fire3dv::app
