// Where this program keeps what it can make again: scenes it has loaded, pipelines it has compiled,
// surroundings it has prepared.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "renderer/scene/scene_cache.h"

namespace fire3dv::app {

struct CachePlaces {
  scene::SceneCacheSettings scenes;
  std::optional<std::filesystem::path> pipelines, surroundings;  // folders
};

// wanted: of --cache. "auto" is the folder that the XDG base directory specification names, where the
// environment has one; "beside" keeps scenes beside their files; "off" keeps nothing; anything else is a
// folder. environment: as std::getenv.
CachePlaces cache_places(std::string_view wanted, const std::function<const char*(const char*)>& environment);

}  // namespace fire3dv::app
