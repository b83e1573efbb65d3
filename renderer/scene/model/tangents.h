// Tangent generator by the definition of MikkTSpace, which normal map bakers use, too.
#pragma once

#include <cstdint>
#include <span>

#include "renderer/scene/model/vertices.h"

namespace fire3dv::scene {

// Generates the tangents of a triangle list. Corners with equal position, normal and texture coordinates
// share a frame if their triangles are connected by edges and not mirrored against each other. A vertex with
// different frames is duplicated, and `indices` refers to the copies.
void generate_tangents(Vertices& vertices, std::span<uint32_t> indices, uint32_t uv_set);

}  // namespace fire3dv::scene
