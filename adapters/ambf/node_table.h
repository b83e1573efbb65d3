// AMBF's objects as the stream's nodes: by which name each is sent. Nodes have AMBF's frames, cameras and
// lights too: what turns these to glTF's is a node below, as fire3dv-convert makes it
// (tools/convert/readers.h).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "adapters/ambf/options.h"

namespace fire3dv::ambf {

// Soft bodies are no nodes: they bring a mesh of their own. But cameras may stand on them.
enum class Kind { rigid_body, ghost_object, light, camera, soft_body };

// Behind a camera's name: the nodes that have its lens. Those of the eyes are there where it sees with two.
constexpr const char* kViewSuffixes[] = {"#view", "#left", "#right"};

struct Object {
  Kind kind = Kind::rigid_body;
  std::string key;   // in AMBF's map of this kind
  std::string name;  // namespace and `name`
};

class NodeTable {
 public:
  NodeTable() = default;
  // An object whose name a renderer would refuse, or that another object has already, is left out and warned
  // of: the others are shown.
  NodeTable(const std::vector<Object>& objects, Options::Names names);

  size_t size() const { return names_.size(); }
  const std::vector<std::string>& names() const { return names_; }
  // None: the object is left out.
  std::optional<size_t> node_of(size_t object) const { return nodes_[object]; }
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  std::vector<std::string> names_;
  std::vector<std::optional<size_t>> nodes_;
  std::vector<std::string> warnings_;
};

// The object that AMBF takes for the child's parent of this name. added: indices of all objects in the order
// in which AMBF adds them. Of those before the child: for each kind the one of that key, else the only one
// whose key has the name in it, and only one kind may answer. Where that is none, the first that is added
// later and has the name in its key.
std::optional<size_t> find_parent(const std::vector<Object>& objects, const std::vector<size_t>& added,
                                  size_t child, const std::string& name);

}  // namespace fire3dv::ambf
