// One scene behind another, with all that is derived of both: what was found for each is not looked for
// again.
#pragma once

#include <string>

#include "renderer/scene/cache/scene_file.h"

namespace fire3dv::scene {

// A name as part of a path.
std::string path_part(const std::string& name);

// A node that the file does not have. parent: kNone for the root. Returns its index.
uint32_t add_node(Scene& scene, const std::string& name, uint32_t parent, const glm::mat4& parent_from_node);

// The asset's roots become children of `parent`. Its nodes are found by their paths alone: a name in it must
// not take that name from a node that was there before. Its animations are left out. What the scene held
// before keeps its places. The error says what there would be too much of.
Result<void> add_below(LoadedScene& to, const LoadedScene& asset, uint32_t parent);

}  // namespace fire3dv::scene
