// Tangents for normal maps, where the file has none.
#pragma once

#include <cstdint>
#include <span>

#include "renderer/scene/scene.h"

namespace fire3dv::scene {

// Fills the tangents of a triangle list. MikkTSpace's frame of each corner (the direction of rising u, made
// normal to the vertex normal, weighted by the corner's angle) is averaged over each vertex. Unlike
// MikkTSpace no vertex is split: where mirrored halves of a texture share a vertex, that vertex follows the
// stronger one.
void generate_tangents(std::span<const glm::vec3> positions, std::span<VertexAttributes> attributes,
                       std::span<const uint32_t> indices, uint32_t uv_set);

}  // namespace fire3dv::scene
