// Vertices and indices of one primitive between file and scene: copies, repairs, conversion of strips, fans
// and loops to lists, flat normals, generated tangents (tangents.cpp) and packed attributes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

struct Vertices {
  std::vector<glm::vec3> positions;
  std::vector<VertexAttributes> attributes;
  std::vector<uint32_t> source;   // accessor element of each vertex; empty: identity
  size_t repaired_normals = 0;    // see repair_normals()
  bool has_bad_tangents = false;  // not finite in the file; replaced
};

// Replaces the vertices: v becomes a copy of vertex copied[v]. All duplication uses this function, so that
// other vertex data can follow `source`.
void copy_vertices(Vertices& vertices, std::span<const uint32_t> copied);

// Repairs invalid attributes: clamps colours to 0..1, replaces tangents that are zero or not finite, and sets
// bitangent signs to 1 or -1.
void sanitize_attributes(Vertices& vertices);

// Recomputes normals that are zero or not finite from the triangles around their vertices. Returns the number
// of such vertices with triangles; the others get the default normal.
size_t repair_normals(Vertices& vertices, std::span<const uint32_t> triangles);

// Keeps glTF's winding; degenerate triangles of a strip are dropped.
std::vector<uint32_t> triangles_of_strip(std::span<const uint32_t> strip);
std::vector<uint32_t> triangles_of_fan(std::span<const uint32_t> fan);

// A loop closes to its first vertex.
std::vector<uint32_t> lines_of_strip(std::span<const uint32_t> strip);
std::vector<uint32_t> lines_of_loop(std::span<const uint32_t> loop);

// Gives each corner its own vertex with the triangle's normal, as glTF requires without normals. Rewrites
// `indices`.
void make_flat(Vertices& vertices, std::span<uint32_t> indices);

// Packed vertex attributes: 16 bytes beside the position, 20 with normal maps. Shaders unpack the same bytes
// (shaders/common/vertices.glsl).
//
// Directions are three signed integers, which unpack without a square root. Normals and tangent xy have 16
// bits, in steps of 1 / 32767. Tangent z has 15 bits, in steps of 1 / 16383, above the bitangent sign bit (1:
// positive). The maximum error is 0.002 degrees for normals and 0.003 degrees for tangents.

// Arguments need not be normalised; zero vectors become (0, 0, 1) and (1, 0, 0).
TangentFrame packed_frame(const glm::vec3& normal, const glm::vec4& tangent);
TangentXy packed_tangent(const glm::vec4& tangent);

glm::vec3 normal_of(const TangentFrame& frame);
glm::vec4 tangent_of(const Scene& scene, uint32_t v);

// All attributes of vertex v, with unpacked normal and tangent.
VertexAttributes attributes_of(const Scene& scene, uint32_t v);

bool has_color(const Scene& scene, uint32_t v);  // true unless it is white

// Appends packed attributes; the caller appends positions.
void append_attributes(Scene& scene, std::span<const VertexAttributes> attributes);

// Generates the tangents of a triangle list by the definition of MikkTSpace, which normal map bakers use,
// too. Corners with equal position, normal and texture coordinates share a frame if their triangles are
// connected by edges and not mirrored against each other. A vertex with different frames is duplicated, and
// `indices` refers to the copies.
void generate_tangents(Vertices& vertices, std::span<uint32_t> indices, uint32_t uv_set);

}  // namespace fire3dv::scene
