// Tangents for normal maps, where the file has none: frames of corners by the definition of MikkTSpace, which
// bakers of normal maps follow too.
#pragma once

#include <cstdint>
#include <span>

#include "renderer/scene/vertices.h"

namespace fire3dv::scene {

// Fills the tangents of a triangle list. Corners of triangles at the same position, normal and texture
// coordinates share a frame where their triangles are joined by edges and are not mirrored against each
// other. Where corners that share a vertex get different frames, the vertex is doubled, and `indices` names
// the copies.
void generate_tangents(Vertices& vertices, std::span<uint32_t> indices, uint32_t uv_set);

}  // namespace fire3dv::scene
