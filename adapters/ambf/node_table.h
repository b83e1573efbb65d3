// Stream node names of AMBF's objects. Nodes keep AMBF's frames, cameras and lights included; a child node
// converts to glTF axes, as in fire3dv-convert's output (tools/convert/readers.h).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "adapters/ambf/options.h"

namespace fire3dv::ambf {

// Soft bodies are no nodes, since they stream their own mesh. Cameras may be attached to them.
enum class Kind { rigid_body, ghost_object, light, camera, soft_body };

// Suffixes of the nodes that carry a camera's lens: mono, and left and right eye of a stereo camera.
constexpr const char* kViewSuffixes[] = {"#view", "#left", "#right"};

struct Object {
  Kind kind = Kind::rigid_body;
  std::string key;   // key in AMBF's map of this kind
  std::string name;  // namespace and `name`
};

class NodeTable {
 public:
  NodeTable() = default;
  // Objects with invalid or duplicate names are skipped with a warning.
  NodeTable(const std::vector<Object>& objects, Options::Names names);

  size_t size() const { return names_.size(); }
  const std::vector<std::string>& names() const { return names_; }
  // Empty: the object is skipped.
  std::optional<size_t> node_of(size_t object) const { return nodes_[object]; }
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  std::vector<std::string> names_;
  std::vector<std::optional<size_t>> nodes_;
  std::vector<std::string> warnings_;
};

// Returns the object that AMBF resolves as the parent `name` of the child. added: indices of all objects in
// creation order. Among objects before the child, each kind offers the exact key, else the only key that
// contains the name. Exactly one kind must match. Otherwise: the first later object whose key contains the
// name.
std::optional<size_t> find_parent(const std::vector<Object>& objects, const std::vector<size_t>& added,
                                  size_t child, const std::string& name);

}  // namespace fire3dv::ambf
