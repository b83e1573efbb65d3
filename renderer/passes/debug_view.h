// What an image shows instead of light, to look into a scene.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace fire3dv::passes {

enum class DebugView : uint8_t {
  none,
  normals,       // of surfaces, in the world: x, y, z as red, green, blue, 0.5 for 0
  depth,         // near is bright
  instances,     // a colour for each node
  clusters,      // a colour for each cluster of triangles that is drawn
  overdraw,      // how many triangles were drawn at a pixel, or tried: black, blue, green, red
  shadow_doubt,  // where shadow maps left the answer to rays
};

// Whether nothing is shaded for it.
inline bool replaces_shading(DebugView view) {
  return view != DebugView::none && view != DebugView::shadow_doubt;
}

// As people write them, in the order of the values.
inline const std::vector<std::string> kDebugViewNames{"none",     "normals",  "depth",       "instances",
                                                      "clusters", "overdraw", "shadow-doubt"};
// name: one of those; anything else stands for the first.
inline DebugView debug_view_named(const std::string& name) {
  for (size_t i = 0; i < kDebugViewNames.size(); ++i) {
    if (kDebugViewNames[i] == name) return static_cast<DebugView>(i);
  }
  return DebugView::none;
}

}  // namespace fire3dv::passes
