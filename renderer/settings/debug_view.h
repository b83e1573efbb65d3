// Debug views: images that show scene or renderer data instead of shaded colours.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace fire3dv::settings {

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

}  // namespace fire3dv::settings
