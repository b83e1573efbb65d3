// What an image shows instead of light, to look into a scene.
#pragma once

#include <cstdint>

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

}  // namespace fire3dv::passes
