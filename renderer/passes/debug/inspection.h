// Inspection requests of a viewer for an image: debug view, outline of the selected node, and picking. They
// use the visibility buffer, so blended surfaces, lines and points are ignored.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "renderer/scene/model/scene.h"

namespace fire3dv::passes {

// Debug views: images that show scene or renderer data instead of shaded colours.
enum class DebugView : uint8_t {
  none,
  normals,             // world-space normals: x, y, z as red, green, blue; 0.5 means 0
  depth,               // near is bright
  instances,           // one colour per node
  clusters,            // one colour per drawn cluster
  overdraw,            // triangles rasterised per pixel, visible or not: black, blue, green, red
  unresolved_shadows,  // pixels that shadow maps left unresolved for rays
};

// True for views that need no shading.
inline bool replaces_shading(DebugView view) {
  return view != DebugView::none && view != DebugView::unresolved_shadows;
}

// User-facing names, in the order of the values.
inline const std::vector<std::string> kDebugViewNames{
    "none", "normals", "depth", "instances", "clusters", "overdraw", "unresolved-shadows"};
// name: one of those; any other string selects the first.
inline DebugView debug_view_named(const std::string& name) {
  for (size_t i = 0; i < kDebugViewNames.size(); ++i) {
    if (kDebugViewNames[i] == name) return static_cast<DebugView>(i);
  }
  return DebugView::none;
}

struct Pick {
  uint32_t x = 0, y = 0;  // pixel, from the upper left corner
  uint64_t tag = 0;       // returned with the result
  bool operator==(const Pick&) const = default;
};

struct Picked {
  uint64_t tag = 0;
  uint32_t node = scene::kNone;  // of the scene that was set at the time; kNone: the background
  glm::vec3 position_world{0};
  float depth_m = 0;             // along the view direction; infinite for the background
  glm::mat4 world_from_node{1};  // of the picked image
};

// Requests for one image.
struct Inspection {
  DebugView debug_view = DebugView::none;
  uint32_t selected = scene::kNone;  // outlined node, including its descendants
  std::optional<Pick> pick;

  bool any() const { return debug_view != DebugView::none || selected != scene::kNone || pick; }
};

}  // namespace fire3dv::passes
