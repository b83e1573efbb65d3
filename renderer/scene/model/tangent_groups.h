// Grouping of triangle corners that share a tangent frame, as MikkTSpace defines it.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace fire3dv::scene {

// Texture-space frame of a triangle.
struct TriangleFrame {
  glm::vec3 rising_u{0};   // unit direction of increasing u
  bool mirrored = false;   // texture-space winding is opposite to the triangle's
  bool undecided = false;  // zero area in texture space: takes the winding of its neighbours
  bool collapsed = false;  // two equal corners: belongs to no group
};

// Group of each corner, or kNone; groups are numbered in order of their first corner. `vertex_of_corner` is
// welded. Sets the winding of undecided triangles.
std::vector<uint32_t> tangent_groups(std::span<const uint32_t> vertex_of_corner,
                                     std::span<TriangleFrame> frames);

}  // namespace fire3dv::scene
