// What a stream changes about the scene besides poses. An edit is state, not an event: it has a key (node,
// property), the newest value of a key is all that counts, and whoever joins late gets the newest values.
// SPEC section 12 is normative. Units and frames as in glTF: metres, radians, linear colour.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <variant>
#include <vector>

#include "protocol/wire/affine.h"

namespace fire3dv::wire {

// With the node's name this is the key. The numbers are the wire's.
enum class Property : uint8_t {
  visible = 0,
  base_color = 1,
  light = 2,
  camera = 3,
  node = 4,  // that there is such a node at all
  vertices = 5,
};
constexpr size_t kPropertyCount = 6;
inline const char* property_name(Property property) {
  constexpr const char* kNames[] = {"visible", "base_color", "light", "camera", "node", "vertices"};
  static_assert(std::size(kNames) == kPropertyCount);
  return kNames[static_cast<size_t>(property)];
}

// The node and all below it: neither drawn nor casting shadows when false.
struct Visible {
  bool visible = true;
  bool operator==(const Visible&) const = default;
};

// Replaces the base colour factor of all materials of the node's own mesh, for this node alone.
struct BaseColor {
  std::array<float, 4> rgba{1, 1, 1, 1};  // linear, 0 to 1
  bool operator==(const BaseColor&) const = default;
};

enum class LightKind : uint8_t { directional = 0, point = 1, spot = 2 };

// The light on the node, new or instead of the file's. It shines along the node's -Z, as in glTF.
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

// The perspective camera on the node, new or instead of the file's. It looks along the node's -Z.
struct Camera {
  float vertical_fov_rad = 0.8f;  // above 0, below pi
  float near_m = 0.01f;           // above 0
  float far_m = 0;                // above near; 0 = infinite
  float exposure = 0;             // factor on linear colour; 0 = as the renderer was told
  bool operator==(const Camera&) const = default;
};

// A node that the scene's file does not have: the roots of a glTF asset become its children. At most one of
// uri and glb is given; with neither the node is empty, and may carry a light or a camera.
struct NodeAdded {
  std::string parent;          // name of another node; empty: the scene's root
  Affine3x4 parent_from_node;  // at rest; poses act on it as on any other node
  // Relative to the folder that the renderer's user named; nothing is fetched from elsewhere.
  std::string asset_uri;
  std::vector<std::byte> asset_glb;  // a whole .glb file
  bool operator==(const NodeAdded&) const = default;
};

// The node and all below it are not there.
struct NodeRemoved {
  bool operator==(const NodeRemoved&) const = default;
};

// New places of the vertices of the node's own mesh, in the frame of the mesh: those of all its primitives
// one after the other, in the order of the file. Triangles stay as they are.
struct Vertices {
  std::vector<std::array<float, 3>> positions;  // metres
  std::vector<std::array<float, 3>> normals;  // as many, or none: the renderer finds them from the triangles
  bool operator==(const Vertices&) const = default;
};

// As the scene's file says.
struct Cleared {
  bool operator==(const Cleared&) const = default;
};

using EditValue = std::variant<Cleared, Visible, BaseColor, Light, Camera, NodeAdded, NodeRemoved, Vertices>;

struct SceneEdit {
  uint64_t epoch = 0;  // of the stream; a publisher's store fills it in
  // Rises by one with each edit of the stream, whatever its key; 0 = not published yet. Edits travel in
  // rising order. Those that a newer edit of the same key has replaced are left out, so that numbers may be
  // missing.
  uint64_t version = 0;
  std::string node;  // found by name or path, as the nodes that poses move
  Property property = Property::visible;
  EditValue value;  // Cleared, or what the property takes: `node` takes NodeAdded and NodeRemoved
  bool operator==(const SceneEdit&) const = default;
};

// Which property a value belongs to; nothing for Cleared, which any property takes.
inline bool fits(Property property, const EditValue& value) {
  constexpr Property kOf[] = {Property::visible, Property::visible, Property::base_color, Property::light,
                              Property::camera,  Property::node,    Property::node,       Property::vertices};
  static_assert(std::size(kOf) == std::variant_size_v<EditValue>);
  return std::holds_alternative<Cleared>(value) || kOf[value.index()] == property;
}

}  // namespace fire3dv::wire
