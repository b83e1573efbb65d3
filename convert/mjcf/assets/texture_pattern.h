// MuJoCo's generated textures: gradient, checker or flat, with marks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace fire3dv::convert {

struct TexturePattern {
  std::string kind, mark;                             // as in MJCF
  glm::dvec3 first{0.8}, second{0.5}, mark_color{0};  // displayed (sRGB)
  double random = 0.01;                               // share of marked pixels
  uint32_t width = 0, height = 0;
};

// RGB, rows from the top.
std::vector<uint8_t> draw_pattern(const TexturePattern& pattern);

// One face of a cube with the pattern, `width` pixels wide and high: right, left, up, down, front or back.
std::vector<uint8_t> draw_face(const TexturePattern& pattern, size_t face);

// Mean linear colour of the six sides of a cube with the pattern.
glm::vec3 mean_of_cube(const TexturePattern& pattern);

}  // namespace fire3dv::convert
