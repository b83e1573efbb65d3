// Names and paths of nodes that are added to a scene in one pass: parents are found as soon as they exist,
// and nodes wait for parents that come later. Ordered maps: names from outside cannot make them slow.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/scene/scene.h"
#include "renderer/state/bindings.h"

namespace fire3dv::app {

class AddedNames {
 public:
  // base: names of the scene before anything is added.
  explicit AddedNames(const state::NodeNames& base) : base_(base) {}

  // Of all nodes, before any is added: the names that they give their parents.
  void expect_parent(const std::string& parent) { parents_.try_emplace(parent); }

  // The node that has this name, or this path and no other node has it; else scene::kNone.
  uint32_t find_parent(const std::string& parent);
  // The node is added once its parent exists.
  void wait(const std::string& parent, size_t node) { parents_[parent].waiting.push_back(node); }

  bool is_taken(const std::string& name) const;  // a node has this name or path

  // A node that has been added, or one of its asset's, whose name counts for nothing. Appends the nodes that
  // waited for it.
  void add(const std::string* name, const std::string& path, uint32_t index, std::vector<size_t>& ready);

  uint64_t lookups() const { return lookups_; }

 private:
  // Shorter first: most comparisons of long paths with a common beginning end at their lengths.
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
