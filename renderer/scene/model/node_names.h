// Names of nodes for errors about a name that nothing has.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// Names of all nodes, or their paths if the wanted name is a path.
inline std::vector<std::string> node_names(const Scene& scene, std::string_view wanted) {
  const bool is_path = wanted.find('/') != std::string_view::npos;
  std::vector<std::string> names;
  names.reserve(scene.nodes.size());
  for (const Node& node : scene.nodes) names.push_back(is_path ? node.path : node.name);
  return names;
}

}  // namespace fire3dv::scene
