// Conversion of strips, fans and loops to lists, and flat normals.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/scene/model/vertices.h"

namespace fire3dv::scene {

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
