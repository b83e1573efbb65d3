// Indices over scene nodes: by name and path, and sets of node numbers. Not thread-safe.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "base/random.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::state {

// Scene nodes by name and path. Nodes of the scene file take precedence over nodes that streams add:
// an added node never takes a name from a file node or makes it ambiguous.
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

// Bit set of small indices with its size and a revision counter. Every change increments the revision.
class IndexSet {
 public:
  IndexSet() = default;
  explicit IndexSet(size_t end) : words_((end + 63) / 64) {}  // holds indices below `end`

  void insert(uint32_t index) { change(index, true); }
  void erase(uint32_t index) { change(index, false); }
  bool contains(uint32_t index) const { return (words_[index / 64] >> (index % 64) & 1) != 0; }
  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  uint64_t revision() const { return revision_; }
  bool has_same(const IndexSet& other) const { return words_ == other.words_; }
  // Restores the revision after a rebuild that produced the same indices.
  void set_revision(uint64_t revision) { revision_ = revision; }

  // Calls visit(index) in ascending order until it returns false.
  template <typename Visit>
  void visit(Visit&& visit) const {
    for (size_t word = 0; word < words_.size(); ++word) {
      for (uint64_t bits = words_[word]; bits != 0; bits &= bits - 1) {
        if (!visit(static_cast<uint32_t>(word * 64 + static_cast<size_t>(std::countr_zero(bits))))) return;
      }
    }
  }

 private:
  void change(uint32_t index, bool present) {
    if (contains(index) == present) return;
    words_[index / 64] ^= uint64_t{1} << (index % 64);
    size_ = present ? size_ + 1 : size_ - 1;
    ++revision_;
  }

  std::vector<uint64_t> words_;
  size_t size_ = 0;
  uint64_t revision_ = 0;
};

}  // namespace fire3dv::state
