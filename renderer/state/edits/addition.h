// Object that the user adds to a scene: a light, a camera, a copy of a node or an asset, as a node of its
// own. Later edits of it are edits of that node.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <variant>

#include "renderer/scene/model/scene.h"
#include "renderer/state/edits/node_transform.h"

namespace fire3dv::state {

// Of a node with all below it, as the file or its stream has them; without other additions below it.
struct CopiedNode {
  std::string path;
  bool operator==(const CopiedNode&) const = default;
};

// glTF file whose roots become children of the node.
struct AddedAsset {
  std::string uri;  // relative to the folder of the overlay file, else to that of --assets
  bool operator==(const AddedAsset&) const = default;
};

struct Addition {
  std::string parent;  // path of a node; empty: the scene's root
  NodeTransform transform;
  std::variant<scene::Light, scene::Camera, CopiedNode, AddedAsset> content;
  bool operator==(const Addition&) const = default;
};
using Additions = std::map<std::string, Addition, std::less<>>;  // by the node's name

std::string path_of(const std::string& name, const Addition& addition);
// True for the path of an added node, or of one below it.
bool is_at_or_below(std::string_view path, std::string_view top);

// Unused name for another object like `name`: name.1, name.2 and so on, without an ending of that kind
// before. is_taken: of a candidate.
template <typename IsTaken>
std::string next_name(std::string name, const IsTaken& is_taken) {
  const size_t dot = name.rfind('.');
  if (dot != std::string::npos && dot + 1 < name.size() &&
      name.find_first_not_of("0123456789", dot + 1) == std::string::npos)
    name.erase(dot);
  for (uint64_t number = 1;; ++number) {
    if (std::string candidate = name + "." + std::to_string(number); !is_taken(candidate)) return candidate;
  }
}

// Materials of a file that was added to the scene, as the node of this name.
struct AddedMaterials {
  std::string owner;
  uint32_t first = 0, count = 0;  // of the scene's materials
};

}  // namespace fire3dv::state
