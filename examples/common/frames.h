// The three frames of the example. The stream is Bullet's world, Z up. glTF's world and the mesh of each node
// in the file are Y up, as an exporter would write them. So a node stands at
//   world_from_stream * stream_from_body * body_from_node
// Both constants are turns by 90 degrees, exact in floating point: a pose of the stream and a rest pose of
// the file agree to the bit.
#pragma once

#include <array>

#include "examples/common/mesh.h"

namespace examples {

// Row-major 3x4.
constexpr std::array<double, 12> kWorldFromStream = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0};
constexpr std::array<float, 12> kBodyFromNode = {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0};

// Z up to Y up: world_from_stream, and node_from_body too.
inline Vec3 y_up(Vec3 a) {
  return {a.x, a.z, -a.y};
}

inline Mesh y_up(Mesh mesh) {
  for (Vertex& v : mesh.vertices)
    v.position = y_up(v.position), v.normal = y_up(v.normal), v.tangent = y_up(v.tangent);
  return mesh;
}

}  // namespace examples
