// Scene edits: changes of a stream to the scene other than poses. An edit is state, not an event: only the
// newest value of a key (node, property) counts, and late joiners receive the newest values. SPEC section 12
// is normative. Units and frames as in glTF: metres, radians, linear colour.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <variant>
#include <vector>

#include "protocol/wire/affine.h"
#include "protocol/wire/input.h"
#include "protocol/wire/marker.h"
#include "protocol/wire/scalar.h"

namespace fire3dv::wire {

// Key of an edit, together with the node's name. The numbers are part of the protocol.
enum class Property : uint8_t {
  visible = 0,
  base_color = 1,
  light = 2,
  camera = 3,
  node = 4,  // existence of the node
  vertices = 5,
  marker = 6,         // the key has the marker's name in place of a node's
  scalars = 7,        // declaration; the key has the group's name in place of a node's
  scalar_values = 8,  // of the group
  input = 9,          // declaration; the key has the input's name in place of a node's
};
constexpr size_t kPropertyCount = 10;
inline const char* property_name(Property property) {
  constexpr const char* kNames[] = {"visible",  "base_color", "light",   "camera",        "node",
                                    "vertices", "marker",     "scalars", "scalar_values", "input"};
  static_assert(std::size(kNames) == kPropertyCount);
  return kNames[static_cast<size_t>(property)];
}

// Visibility of a node and its descendants; hidden nodes cast no shadows.
struct Visible {
  bool visible = true;
  bool operator==(const Visible&) const = default;
};

// Base colour factor of all materials of the node's own mesh, for this node only.
struct BaseColor {
  std::array<float, 4> rgba{1, 1, 1, 1};  // linear, 0 to 1
  bool operator==(const BaseColor&) const = default;
};

enum class LightKind : uint8_t { directional = 0, point = 1, spot = 2 };

// Light of the node; adds or replaces the file's light. Points along the node's -Z, as in glTF.
struct Light {
  LightKind kind = LightKind::point;
  std::array<float, 3> color_rgb{1, 1, 1};  // linear
  float intensity = 1;                      // candela (point, spot) or lux (directional)
  float range_m = 0;                        // 0 = infinite
  float inner_cone_rad = 0;                 // spot: 0 <= inner < outer <= pi / 2
  float outer_cone_rad = 0.7853981634f;
  bool casts_shadow = true;
  bool operator==(const Light&) const = default;
};

// Bounds of the thin lens of cameras and image requests.
constexpr float kMinFNumber = 0.1f, kMaxFNumber = 1000;
constexpr float kMinFocusDistanceM = 1e-3f, kMaxFocusDistanceM = 1e6f;

// Perspective camera of the node; adds or replaces the file's camera. Looks along the node's -Z.
struct Camera {
  float vertical_fov_rad = 0.8f;  // above 0, below pi
  float near_m = 0.01f;           // above 0
  float far_m = 0;                // above near; 0 = infinite
  float exposure = 0;             // factor on linear colour; 0 = renderer's setting
  // Thin lens, both or none; 0 = as the file or the renderer's settings have it.
  float f_number = 0;          // focal length over the diameter of the aperture
  float focus_distance_m = 0;  // along the view direction
  bool operator==(const Camera&) const = default;
};

// Additional node: the roots of a glTF asset become its children. At most one of uri and glb is set; with
// neither the node is empty, and may carry a light or a camera.
struct NodeAdded {
  std::string parent;          // name of another node; empty: the scene's root
  Affine3x4 parent_from_node;  // rest pose; pose frames apply as to any other node
  // Path relative to the user's asset folder; never fetched from elsewhere.
  std::string asset_uri;
  std::vector<std::byte> asset_glb;  // contents of a .glb file
  std::string variant = {};          // name of the asset's material variant; empty: its default materials
  bool operator==(const NodeAdded&) const = default;
};

// Removes the node and its descendants.
struct NodeRemoved {
  bool operator==(const NodeRemoved&) const = default;
};

// New vertex positions of the node's own mesh, in mesh space: of all primitives, concatenated in file order.
// The triangles are unchanged.
struct Vertices {
  std::vector<std::array<float, 3>> positions;  // metres
  std::vector<std::array<float, 3>> normals;    // same count, or empty: computed from the triangles
  bool operator==(const Vertices&) const = default;
};

// Restores the file's value.
struct Cleared {
  bool operator==(const Cleared&) const = default;
};

using EditValue = std::variant<Cleared, Visible, BaseColor, Light, Camera, NodeAdded, NodeRemoved, Vertices,
                               Marker, Scalars, ScalarValues, Input>;

struct SceneEdit {
  uint64_t epoch = 0;  // of the stream; set by the publisher's store
  // Rises by one with each edit of the stream, whatever its key; 0 = not published. Edits are sent in rising
  // order. Replaced edits are omitted, so that numbers may be missing.
  uint64_t version = 0;
  // Name or path, resolved like posed nodes; of a marker, a group of scalars or an input: its own name.
  std::string node;
  Property property = Property::visible;
  EditValue value;  // Cleared, or a value of the property; `node` takes NodeAdded and NodeRemoved
  bool operator==(const SceneEdit&) const = default;
};

inline bool is_scalar(Property property) {
  return property == Property::scalars || property == Property::scalar_values;
}

// False for what no image shows: frames do not wait for such edits.
inline bool delays_frames(Property property) {
  return !is_scalar(property) && property != Property::input;
}

// True if the value belongs to the property; Cleared belongs to every property.
inline bool fits(Property property, const EditValue& value) {
  constexpr Property kOf[] = {Property::visible, Property::visible,       Property::base_color,
                              Property::light,   Property::camera,        Property::node,
                              Property::node,    Property::vertices,      Property::marker,
                              Property::scalars, Property::scalar_values, Property::input};
  static_assert(std::size(kOf) == std::variant_size_v<EditValue>);
  return std::holds_alternative<Cleared>(value) || kOf[value.index()] == property;
}

}  // namespace fire3dv::wire
