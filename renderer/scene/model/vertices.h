// Vertices and indices of one primitive between file and scene: copies, repairs, conversion of strips, fans
// and loops to lists, and flat normals.
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

// Keeps glTF's winding; degenerate triangles of a strip are dropped.
std::vector<uint32_t> triangles_of_strip(std::span<const uint32_t> strip);
std::vector<uint32_t> triangles_of_fan(std::span<const uint32_t> fan);

// A loop closes to its first vertex.
std::vector<uint32_t> lines_of_strip(std::span<const uint32_t> strip);
std::vector<uint32_t> lines_of_loop(std::span<const uint32_t> loop);

// Gives each corner its own vertex with the triangle's normal, as glTF requires without normals. Rewrites
// `indices`.
void make_flat(Vertices& vertices, std::span<uint32_t> indices);

}  // namespace fire3dv::scene
