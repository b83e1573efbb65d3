// Colours of the window's own markers: R | G << 8 | B << 16 | A << 24, sRGB.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>

namespace fire3dv::app {

// hex: 0xRRGGBB.
constexpr uint32_t marker_color(uint32_t hex, uint32_t alpha = 0xff) {
  return (hex >> 16 & 0xff) | (hex & 0xff00) | (hex & 0xff) << 16 | alpha << 24;
}
constexpr std::array<uint32_t, 3> kAxisColors{marker_color(0xe0483e), marker_color(0x4fb04a),
                                              marker_color(0x3f7fe0)};

inline std::array<float, 3> marker_point(const glm::vec3& v) {
  return {v.x, v.y, v.z};
}

}  // namespace fire3dv::app
