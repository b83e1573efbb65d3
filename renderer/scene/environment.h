// What surrounds a scene: the radiance that comes from each direction, as an equirectangular image. The
// middle of the image lies along -Z, where a camera at rest looks; +X is to the right of it and +Y at the
// top.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

namespace fire3dv::scene {

struct EnvironmentImage {
  uint32_t width = 0, height = 0;
  std::vector<uint32_t>
      rgb9e5;       // rows from the top; three mantissas of 9 bits and one exponent of 5 (from the top)
  float scale = 1;  // radiance = scale * texel: the sun may be brighter than a texel can say
};

// The format's largest number.
constexpr float kMostRgb9e5 = 65408;

// Negative numbers and NaN become 0; too large ones the largest.
uint32_t pack_rgb9e5(glm::vec3 color);
glm::vec3 unpack_rgb9e5(uint32_t packed);

// Unit direction through a point of the image, 0..1 each, v from the top.
glm::vec3 environment_direction(float u, float v);

EnvironmentImage make_environment(uint32_t width, uint32_t height,
                                  const std::function<glm::vec3(const glm::vec3& direction)>& radiance);

// The default surroundings: a neutral studio with a bright ceiling, a darker floor and two soft panels, so
// that metals have something to reflect and shadows are not black.
EnvironmentImage studio_environment();

}  // namespace fire3dv::scene
