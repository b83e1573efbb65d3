// Names and paths of the nodes that one scene build adds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "renderer/scene/model/scene.h"
#include "renderer/state/node_index.h"

namespace fire3dv::app {

// Name index of nodes that are added to a scene in one pass. Parents are found as soon as they exist; nodes
// wait for parents that come later. Ordered maps: untrusted names cannot degrade the lookup time.
class PendingNames {
 public:
  // base: names of the scene before any addition.
  explicit PendingNames(const state::NodeNames& base) : base_(base) {}

  // Declares the parent name of a node. Must be called for all nodes before the first add().
  void declare_parent(const std::string& parent) { parents_.try_emplace(parent); }

  // Node with this name, or the unique node with this path; otherwise scene::kNone.
  uint32_t find_parent(const std::string& parent);
  // Node with this path, or scene::kNone if there is none or several. scene: the names are of its nodes.
  uint32_t find_path(const std::string& path, const scene::Scene& scene);
  // Defers the node until its parent exists.
  void wait(const std::string& parent, size_t node) { parents_[parent].waiting.push_back(node); }

  bool is_taken(const std::string& name) const;  // true if a node has this name or path

  // Adds a node, or a node of its asset, whose name is not indexed (null). Appends the nodes that waited for
  // it to `ready`.
  void add(const std::string* name, const std::string& path, uint32_t index, std::vector<size_t>& ready);

  uint64_t lookups() const { return lookups_; }

 private:
  // Shorter strings first: most comparisons of long paths with a common prefix end at the lengths.
  struct ByLength {
    bool operator()(const std::string& a, const std::string& b) const {
      return a.size() != b.size() ? a.size() < b.size() : a < b;
    }
  };
  struct Parent {
    uint32_t by_name = scene::kNone, by_path = scene::kNone;
    bool path_is_ambiguous = false;
    std::vector<size_t> waiting;
  };
  const state::NodeNames& base_;
  std::map<std::string, Parent, ByLength> parents_;
  std::set<std::string, ByLength> names_and_paths_;
  uint64_t lookups_ = 0;
};

}  // namespace fire3dv::app
