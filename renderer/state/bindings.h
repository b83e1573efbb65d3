// Index of scene nodes by name and path. Nodes of the scene file take precedence over nodes that streams add:
// an added node never takes a name from a file node or makes it ambiguous.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "protocol/base/keyed_hash.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::state {

class NodeNames {
 public:
  // file_nodes: the number of leading nodes that belong to the scene file; all others were added.
  explicit NodeNames(const scene::Scene& scene, uint32_t file_nodes = UINT32_MAX);

  // Returns the only node with this exact name, else the only node with this path, else scene::kNone. Added
  // nodes count only where no file node has the name or path.
  uint32_t find(std::string_view name) const;
  // has() finds nodes of the file and added nodes, file_has() nodes of the file. Several matches count, too.
  bool has(std::string_view name) const { return has(file_, name) || has(added_, name); }
  bool file_has(std::string_view name) const { return has(file_, name); }
  // Returns the first node in scene order with this path, or scene::kNone.
  uint32_t first_of_path(std::string_view path) const;

  // Length of the longest hash bucket; tests check resistance to chosen collisions.
  size_t longest_bucket() const;

 private:
  // A name that several nodes share is ambiguous and binds no node.
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
