// AMBF's objects as nodes of the stream: names, transforms, and cameras defined in world and model files
// (ADF). Nodes keep AMBF's frames, cameras and lights included; a child node converts to glTF axes, as in
// fire3dv-convert's output (convert/readers.h).
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "adapters/ambf/options.h"

namespace fire3dv::ambf {

// Rigid transform in chai3d's layout: doubles, column-major, m[column][row], so that AMBF's frames are copied
// with memcpy. The stream frame is AMBF's world: Z up, metres.
struct Transform {
  double m[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
};

// Returns a_from_c for a_from_b and b_from_c. Both are affine; the last row is ignored.
inline Transform operator*(const Transform& a, const Transform& b) {
  Transform product;
  for (size_t column = 0; column < 4; ++column) {
    for (size_t row = 0; row < 3; ++row) {
      product.m[column][row] = a.m[0][row] * b.m[column][0] + a.m[1][row] * b.m[column][1] +
                               a.m[2][row] * b.m[column][2] + (column == 3 ? a.m[3][row] : 0.0);
    }
  }
  return product;
}

// Converts to the wire layout: 3 rows of 4 floats. Returns false, without writing, for numbers that the wire
// refuses.
inline bool to_pose(const Transform& from, float* pose) {
  constexpr double kMaxMagnitude = 1e12;  // limit of protocol/SPEC.md
  for (size_t column = 0; column < 4; ++column) {
    for (size_t row = 0; row < 3; ++row) {
      if (!(std::abs(from.m[column][row]) <= kMaxMagnitude)) return false;
    }
  }
  for (size_t row = 0; row < 3; ++row) {
    for (size_t column = 0; column < 4; ++column)
      pose[row * 4 + column] = static_cast<float>(from.m[column][row]);
  }
  return true;
}

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

struct Intrinsics {
  double vertical_fov_rad = 0.7;
  double near_m = 0.1;
  double far_m = 10;
  bool two_eyes = false;  // stereo: AMBF draws the left and right views side by side
  bool operator==(const Intrinsics&) const = default;
};

// Camera in AMBF's camera frame: looks along -X, +Y right, +Z up.
struct CameraDefinition {
  std::string key;     // key in AMBF's camera map
  std::string name;    // namespace and `name`
  std::string parent;  // key of an object, or a part of one; empty: the world
  Transform parent_from_camera;
  std::optional<Intrinsics> intrinsics;  // empty: orthographic camera
};

// Object listed in a file, by its key in AMBF's maps.
struct Listed {
  Kind kind = Kind::rigid_body;
  std::string key;
};

struct CameraDefinitions {
  std::vector<CameraDefinition> cameras;
  std::vector<Listed>
      // All objects, cameras included, in AMBF's creation order, which decides parent look-ups.
      listed;
  std::vector<std::string> warnings;  // one message per unreadable file or camera
};

// Reads ADF files. Parsing never fails as a whole: unreadable files and cameras become warnings.
CameraDefinitions read_cameras(const Launch& launch);

// Joins the namespace of a file with the namespace of a block, as AMBF does.
std::string merge_namespaces(const std::string& outer, const std::string& inner);

// Returns the camera frame for a position, a target and an up vector. Empty for degenerate directions.
std::optional<Transform> look_at(const double (&position)[3], const double (&target)[3],
                                 const double (&up)[3]);

}  // namespace fire3dv::ambf
