// Finder of the Gazebo world to show: names of worlds from announced services, and advice when there is none.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "adapters/gazebo/wire/directory.h"
#include "base/error.h"

namespace fire3dv::gazebo {

// Worlds with a scene/info service, sorted.
std::vector<std::string> world_names(const Directory& directory);

// Returns the world to show: the wanted one, or the only one. Nullopt: none yet. An error lists several.
Result<std::optional<std::string>> choose_world(const Directory& directory, const std::string& wanted);

// Says where a world was looked for, what was seen instead and what to do.
std::string missing_world_advice(const Directory& directory, const std::string& wanted,
                                 const std::vector<std::string>& interfaces);

}  // namespace fire3dv::gazebo
