// Vertices of one primitive between file and scene.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

struct Vertices {
  std::vector<glm::vec3> positions;
  std::vector<VertexAttributes> attributes;
  std::vector<uint32_t> source;  // accessor element of each vertex; empty: identity
};

// Replaces the vertices: v becomes a copy of vertex copied[v]. All duplication uses this function, so that
// other vertex data can follow `source`.
void copy_vertices(Vertices& vertices, std::span<const uint32_t> copied);

// Repairs invalid attributes: clamps colours to 0..1, replaces zero normals and tangents, and sets bitangent
// signs to 1 or -1.
void sanitize_attributes(Vertices& vertices);

}  // namespace fire3dv::scene
