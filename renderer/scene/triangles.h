// Lists of triangles and lines from the other topologies, and what can be derived from a list of triangles
// alone.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/scene/vertices.h"

namespace fire3dv::scene {

// In glTF's winding; triangles of a strip that repeat an index only join its pieces and are dropped.
std::vector<uint32_t> triangles_of_strip(std::span<const uint32_t> strip);
std::vector<uint32_t> triangles_of_fan(std::span<const uint32_t> fan);

// The loop comes back to its first vertex.
std::vector<uint32_t> lines_of_strip(std::span<const uint32_t> strip);
std::vector<uint32_t> lines_of_loop(std::span<const uint32_t> loop);

// Gives each corner of each triangle its own vertex with the triangle's normal, as glTF asks for where
// normals are missing. `indices` is renumbered.
void make_flat(Vertices& vertices, std::span<uint32_t> indices);

}  // namespace fire3dv::scene
