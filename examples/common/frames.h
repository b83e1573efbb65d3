// Coordinate frames of the examples. The stream frame is the simulator's: Z up. The renderer's world and the
// node meshes follow glTF: Y up. A node's pose is world_from_stream * stream_from_body * body_from_node. Both
// constants are rotations by 90 degrees without rounding, so that stream poses and rest poses agree bit by
// bit.
#pragma once

#include <array>

#include "examples/common/mesh.h"

namespace examples {

// 3x4, row-major.
constexpr std::array<double, 12> kWorldFromStream = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0};
constexpr std::array<float, 12> kBodyFromNode = {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0};

// Z up to Y up; serves as world_from_stream and node_from_body.
inline Vec3 y_up(Vec3 a) {
  return {a.x, a.z, -a.y};
}

inline Mesh y_up(Mesh mesh) {
  for (Vertex& v : mesh.vertices)
    v.position = y_up(v.position), v.normal = y_up(v.normal), v.tangent = y_up(v.tangent);
  return mesh;
}

}  // namespace examples
