#include "tools/lab/bench/surfaces.h"

#include <cmath>
#include <functional>
#include <string>

#include "protocol/base/parallel.h"
#include "tools/lab/bench/random.h"

namespace fire3dv::bench {
namespace {

constexpr uint32_t kSets = 8;
constexpr uint32_t kTexturesOfSet = 3;

// Tileable smooth noise from 0 to 1.
class Noise {
 public:
  explicit Noise(uint64_t seed) {
    Random random(seed);
    for (float& value : values_) value = random.uniform(0, 1);
  }

  float at(float u, float v, uint32_t cells) const {
    const float x = u * static_cast<float>(cells), y = v * static_cast<float>(cells);
    const float fx = std::floor(x), fy = std::floor(y);
    const auto ix = static_cast<uint32_t>(fx), iy = static_cast<uint32_t>(fy);
    const float tx = ease(x - fx), ty = ease(y - fy);
    return glm::mix(glm::mix(value(ix, iy, cells), value(ix + 1, iy, cells), tx),
                    glm::mix(value(ix, iy + 1, cells), value(ix + 1, iy + 1, cells), tx), ty);
  }

 private:
  static constexpr uint32_t kSide = 64;
  static float ease(float t) { return t * t * (3 - 2 * t); }
  float value(uint32_t x, uint32_t y, uint32_t cells) const {
    return values_[(y % cells) % kSide * kSide + (x % cells) % kSide];
  }
  float values_[kSide * kSide];
};

// Texture set: panels with grooves and uneven wear.
struct Pattern {
  Noise noise;
  uint32_t panels;

  explicit Pattern(uint32_t set) : noise(1000 + set), panels(2 + set % 4) {}

  float wear(float u, float v) const { return 0.6f * noise.at(u, v, 8) + 0.4f * noise.at(u, v, 32); }
  float height(float u, float v) const {
    const float n = static_cast<float>(panels);
    const glm::vec2 in_panel(u * n - std::floor(u * n), v * n - std::floor(v * n));
    const glm::vec2 from_edge = glm::min(in_panel, 1.0f - in_panel);
    const float groove = glm::smoothstep(0.02f, 0.08f, std::min(from_edge.x, from_edge.y));
    return groove * 0.02f + 0.004f * wear(u, v);
  }

  glm::vec4 base_color(float u, float v) const {
    const float groove = glm::smoothstep(0.0f, 0.02f, height(u, v));
    const float light = glm::mix(0.35f, 1.0f, groove) * (0.75f + 0.25f * wear(u, v));
    return glm::vec4(glm::vec3(light), 1);
  }
  glm::vec4 normal(float u, float v, float texel) const {
    const float du =
        (height(u + texel, v) - height(u - texel < 0 ? u - texel + 1 : u - texel, v)) / (2 * texel);
    const float dv =
        (height(u, v + texel) - height(u, v - texel < 0 ? v - texel + 1 : v - texel)) / (2 * texel);
    const glm::vec3 n = glm::normalize(glm::vec3(-du, dv, 1));  // green points up, v runs downwards
    return glm::vec4(n * 0.5f + 0.5f, 1);
  }
  glm::vec4 metallic_roughness(float u, float v) const { return {1, 0.6f + 0.4f * wear(u, v), 1, 1}; }
};

void paint(scene::Image& image, uint32_t side, const std::function<glm::vec4(float, float)>& texel) {
  image.width = image.height = side;
  image.rgba8.edit().resize(size_t{4} * side * side);
  uint8_t* out = image.rgba8.edit().data();
  for (uint32_t y = 0; y < side; ++y) {
    for (uint32_t x = 0; x < side; ++x) {
      const glm::vec4 value = texel((static_cast<float>(x) + 0.5f) / static_cast<float>(side),
                                    (static_cast<float>(y) + 0.5f) / static_cast<float>(side));
      for (int c = 0; c < 4; ++c)
        *out++ = static_cast<uint8_t>(glm::clamp(value[c], 0.0f, 1.0f) * 255.0f + 0.5f);
    }
  }
}

void paint_texture(uint32_t number, uint32_t side, scene::Image& image) {
  const Pattern pattern(number / kTexturesOfSet);
  const std::string set = std::to_string(number / kTexturesOfSet);
  const float texel = 1 / static_cast<float>(side);
  switch (number % kTexturesOfSet) {
    case 0:
      image.name = "base_color_" + set;
      return paint(image, side, [&](float u, float v) { return pattern.base_color(u, v); });
    case 1:
      image.name = "normal_" + set;
      return paint(image, side, [&](float u, float v) { return pattern.normal(u, v, texel); });
    default:
      image.name = "metallic_roughness_" + set;
      return paint(image, side, [&](float u, float v) { return pattern.metallic_roughness(u, v); });
  }
}

}  // namespace

Surfaces make_surfaces(uint32_t side) {
  Surfaces surfaces;
  if (side > 0) {
    surfaces.images.resize(size_t{kSets} * kTexturesOfSet);
    parallel_for(surfaces.images.size(),
                 [&](size_t i) { paint_texture(static_cast<uint32_t>(i), side, surfaces.images[i]); });
    for (uint32_t i = 0; i < surfaces.images.size(); ++i)
      surfaces.textures.push_back({i, {}, i % kTexturesOfSet == 0});
  }

  surfaces.materials.resize(2);
  scene::Material& ground = surfaces.materials[1];
  ground.name = "ground";
  ground.base_color = {0.45f, 0.45f, 0.45f, 1};
  ground.metallic = 0;
  ground.roughness = 0.9f;
  Random random(1);
  for (uint32_t m = 0; m < kMaterials; ++m) {
    scene::Material material;
    material.name = "material_" + std::to_string(m);
    for (int c = 0; c < 3; ++c) material.base_color[c] = random.uniform(0.15f, 0.95f);
    material.metallic = m % 4 == 3 ? 1.0f : 0.0f;
    material.roughness = random.uniform(0.2f, 0.8f);
    if (side > 0) {
      const uint32_t first = m % kSets * kTexturesOfSet;
      material.base_color_texture.texture = first;
      material.normal_texture.texture = first + 1;
      material.metallic_roughness_texture.texture = first + 2;
    }
    surfaces.materials.push_back(material);
  }
  return surfaces;
}

}  // namespace fire3dv::bench
