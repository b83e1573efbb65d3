// The vertices of one primitive on their way from the file into the scene.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/scene/scene.h"

namespace fire3dv::scene {

struct Vertices {
  std::vector<glm::vec3> positions;
  std::vector<VertexAttributes> attributes;
  std::vector<uint32_t> source;  // the accessors' element of each vertex; empty: in their order
};

// Vertex v of the result is a copy of vertex copied[v]. All that makes or doubles vertices goes through here,
// so that whatever else there is of a vertex can follow `source`.
void copy_vertices(Vertices& vertices, std::span<const uint32_t> copied);

// Puts right what shading could not use: colours beyond white or below black, normals and tangents without a
// direction, and signs of bitangents that are none.
void make_usable(Vertices& vertices);

}  // namespace fire3dv::scene
