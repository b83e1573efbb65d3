// Index of scene nodes by name and path. Nodes of the scene's file come first: nodes that streams add never
// take a name from them or make one of theirs ambiguous.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>

#include "protocol/base/keyed_hash.h"
#include "renderer/scene/scene.h"

namespace fire3dv::state {

class NodeNames {
 public:
  // file_nodes: the first nodes of the scene that are of its file; the others were added to it.
  explicit NodeNames(const scene::Scene& scene, uint32_t file_nodes = UINT32_MAX);

  // The node of exactly this name if only one has it, else the node of this path if only one has it, else
  // scene::kNone. Added nodes count only where no node of the file has the name or path.
  uint32_t find(std::string_view name) const;
  // Some node, or some node of the scene's file, has this name or path, be it one or several.
  bool has(std::string_view name) const { return has(file_, name) || has(added_, name); }
  bool file_has(std::string_view name) const { return has(file_, name); }
  // The node that stands first in the scene among those of this path; scene::kNone: none has it.
  uint32_t first_of_path(std::string_view path) const;

  // Longest chain of nodes whose names fall into one bucket, for tests.
  size_t longest_bucket() const;

 private:
  // Names that several nodes share bind nothing rather than the first of them.
  struct Entry {
    uint32_t first = scene::kNone;
    bool is_shared = false;
  };
  using Index = std::unordered_map<std::string, Entry, KeyedHash, std::equal_to<>>;
  struct Layer {
    Index by_name, by_path;
  };
  static void insert(Index& index, const std::string& name, uint32_t node);
  static bool has(const Layer& layer, std::string_view name) {
    return lookup(layer.by_name, name) || lookup(layer.by_path, name);
  }
  static const Entry* lookup(const Index& index, std::string_view name);

  Layer file_, added_;
};

}  // namespace fire3dv::state
