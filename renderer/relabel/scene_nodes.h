// Scene nodes as targets of imported states.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/import/import.h"
#include "renderer/scene/model/scene.h"
#include "renderer/state/node_index.h"

namespace fire3dv::relabel {

// By name or path; nothing for a name that no node or several have. The scale of a node, and of those above
// it, stays: states are rigid.
std::optional<imported::SceneNode> find_node(const scene::Scene& scene, const state::NodeNames& names,
                                             std::string_view name);

// Paths of nodes with meshes that neither move nor have a node above them that moves.
std::vector<std::string> resting_nodes(const scene::Scene& scene,
                                       const std::vector<imported::SceneNode>& moving);

}  // namespace fire3dv::relabel
