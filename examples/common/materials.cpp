#include "examples/common/materials.h"

#include <cmath>
#include <cstdio>

namespace examples {
namespace {

std::array<float, 3> from_hue(float hue, float saturation, float value) {
  std::array<float, 3> color{};
  for (size_t i = 0; i < 3; ++i) {
    const float k = std::fmod(static_cast<float>(5 - 2 * static_cast<int>(i)) + hue * 6, 6.0f);
    const float share = std::fmax(0.0f, std::fmin(1.0f, std::fmin(k, 4 - k)));
    color[i] = std::pow(value * (1 - saturation * share), 2.2f);
  }
  return color;
}

}  // namespace

std::vector<Material> make_materials() {
  std::vector<Material> materials = {
      {"floor", {1, 1, 1}, 0, 1, Surface::floor},
      // Emissive with little reflection, so that it shows no shadows.
      {"backdrop", {0.01f, 0.012f, 0.015f}, 0, 1, Surface::plain, {0.036f, 0.048f, 0.068f}},
      {"brushed_metal", {0.80f, 0.81f, 0.83f}, 1, 0.36f},
      {"dark_metal", {0.30f, 0.31f, 0.34f}, 1, 0.5f},
      {"chrome", {0.92f, 0.93f, 0.95f}, 1, 0.26f},
      {"gold", {1.00f, 0.71f, 0.29f}, 1, 0.36f},
      {"copper", {0.95f, 0.50f, 0.34f}, 1, 0.38f},
      {"painted_orange", {0.86f, 0.19f, 0.02f}, 0, 0.36f},
      {"painted_white", {0.78f, 0.77f, 0.74f}, 0, 0.32f},
      {"painted_teal", {0.02f, 0.30f, 0.34f}, 0, 0.30f},
      {"painted_graphite", {0.055f, 0.06f, 0.07f}, 0, 0.48f},
      {"rubber", {0.022f, 0.022f, 0.024f}, 0, 0.88f},
      {"plastic_red", {0.68f, 0.025f, 0.03f}, 0, 0.18f},
      {"plastic_blue", {0.025f, 0.13f, 0.60f}, 0, 0.18f},
      {"plastic_yellow", {0.85f, 0.55f, 0.03f}, 0, 0.20f},
      {"plastic_green", {0.05f, 0.42f, 0.09f}, 0, 0.20f},
      {"plastic_teal", {0.02f, 0.42f, 0.42f}, 0, 0.18f},
      {"plastic_violet", {0.28f, 0.07f, 0.48f}, 0, 0.20f},
      {"wood", {1, 1, 1}, 0, 1, Surface::wood},
      {"wood_dark", {0.40f, 0.27f, 0.20f}, 0, 1, Surface::wood},
  };
  for (int i = 0; i < 12; ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "domino_hue_%02d", i);
    materials.push_back({name, from_hue(static_cast<float>(i) / 13.0f, 0.80f, 0.92f), 0, 0.24f});
  }
  return materials;
}

}  // namespace examples
