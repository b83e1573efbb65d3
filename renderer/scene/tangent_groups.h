// Which corners of a triangle list share a tangent frame.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace fire3dv::scene {

// What the texture coordinates say of a triangle.
struct TriangleFrame {
  glm::vec3 rising_u{0};   // the direction, of length 1
  bool mirrored = false;   // u and v turn the other way round than the triangle's corners
  bool undecided = false;  // they span no area: the triangle takes the sense of its neighbours
  bool collapsed = false;  // two corners at one place: it joins nothing
};

// Of each corner its group, or kNone; groups count from 0 in the order of their first corner.
// `vertex_of_corner` names equal vertices equally. Undecided triangles take on a sense here.
std::vector<uint32_t> tangent_groups(std::span<const uint32_t> vertex_of_corner,
                                     std::span<TriangleFrame> frames);

}  // namespace fire3dv::scene
