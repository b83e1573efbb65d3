// Colour conversion from sRGB, as description files use it, to linear light.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

namespace fire3dv::convert {

inline glm::vec3 linear_from_srgb(const glm::vec3& displayed) {
  glm::vec3 linear;
  for (int i = 0; i < 3; ++i) {
    const float c = std::clamp(displayed[i], 0.0f, 1.0f);
    linear[i] = c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
  }
  return linear;
}

// a: opacity, unchanged.
inline glm::vec4 linear_from_srgb(const glm::vec4& displayed) {
  return {linear_from_srgb(glm::vec3(displayed)), std::clamp(displayed.a, 0.0f, 1.0f)};
}

}  // namespace fire3dv::convert
