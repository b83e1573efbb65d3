#include "renderer/scene/textures/environment.h"

#include <algorithm>
#include <cmath>

namespace fire3dv::scene {
namespace {

constexpr int kExponentBias = 15, kMantissaBits = 9, kMaxExponent = 31;
constexpr float kPi = 3.14159265358979f;

glm::vec3 studio_radiance(const glm::vec3& direction) {
  const float up = glm::smoothstep(-0.15f, 0.15f, direction.y);
  const float panels =
      glm::smoothstep(0.80f, 0.95f, glm::dot(direction, glm::normalize(glm::vec3(0.5f, 0.6f, 0.6f)))) +
      glm::smoothstep(0.85f, 0.97f, glm::dot(direction, glm::normalize(glm::vec3(-0.8f, 0.4f, -0.1f))));
  constexpr glm::vec3 kFloor(0.105f, 0.1015f, 0.098f), kCeiling(0.385f, 0.392f, 0.4025f);
  return glm::mix(kFloor, kCeiling, up) + panels * 0.525f;
}

}  // namespace

uint32_t pack_rgb9e5(glm::vec3 color) {
  for (int c = 0; c < 3; ++c) color[c] = color[c] > 0 ? std::min(color[c], kMaxRgb9e5) : 0;  // NaN becomes 0
  const float largest = std::max({color.r, color.g, color.b});
  int exponent = std::max(-kExponentBias - 1, largest > 0 ? std::ilogb(largest) : -kExponentBias - 1) + 1 +
                 kExponentBias;
  float step = std::ldexp(1.0f, exponent - kExponentBias - kMantissaBits);
  if (std::lround(largest / step) == 1 << kMantissaBits) {  // rounding needs one more bit
    step *= 2;
    ++exponent;
  }
  exponent = std::min(exponent, kMaxExponent);
  const auto mantissa = [&](float value) { return static_cast<uint32_t>(std::lround(value / step)); };
  return mantissa(color.r) | mantissa(color.g) << 9 | mantissa(color.b) << 18 |
         static_cast<uint32_t>(exponent) << 27;
}

glm::vec3 unpack_rgb9e5(uint32_t packed) {
  const float step = std::ldexp(1.0f, static_cast<int>(packed >> 27) - kExponentBias - kMantissaBits);
  return step * glm::vec3(packed & 0x1ff, packed >> 9 & 0x1ff, packed >> 18 & 0x1ff);
}

glm::vec3 environment_direction(float u, float v) {
  const float around = (u - 0.5f) * 2 * kPi, down = v * kPi;
  return {std::sin(down) * std::sin(around), std::cos(down), -std::sin(down) * std::cos(around)};
}

EnvironmentImage make_environment(uint32_t width, uint32_t height,
                                  const std::function<glm::vec3(const glm::vec3& direction)>& radiance) {
  EnvironmentImage image;
  image.width = width;
  image.height = height;
  image.rgb9e5.reserve(size_t{width} * height);
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      image.rgb9e5.push_back(pack_rgb9e5(
          radiance(environment_direction((static_cast<float>(x) + 0.5f) / static_cast<float>(width),
                                         (static_cast<float>(y) + 0.5f) / static_cast<float>(height)))));
    }
  }
  return image;
}

EnvironmentImage studio_environment() {
  return make_environment(512, 256, studio_radiance);
}

}  // namespace fire3dv::scene
