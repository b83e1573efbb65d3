#include "examples/common/materials.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

namespace examples {

namespace {

float hash01(int x, int y, int salt) {
  uint32_t h = static_cast<uint32_t>(x) * 0x8da6b343u ^ static_cast<uint32_t>(y) * 0xd8163841u ^
               static_cast<uint32_t>(salt) * 0xcb1ab31fu;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return static_cast<float>((h ^ (h >> 15)) >> 8) / 16777216.0f;
}

float smooth(float t) {
  return t * t * (3 - 2 * t);
}
float mix(float a, float b, float t) {
  return a + (b - a) * t;
}
float step_between(float low, float high, float x) {
  return smooth(std::clamp((x - low) / (high - low), 0.0f, 1.0f));
}

// Tileable value noise over the unit square; cells per side are whole numbers for that.
float noise(float u, float v, int cells_u, int cells_v, int salt) {
  const float x = u * static_cast<float>(cells_u), y = v * static_cast<float>(cells_v);
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const float tx = smooth(x - static_cast<float>(x0)), ty = smooth(y - static_cast<float>(y0));
  auto at = [&](int cx, int cy) {
    return hash01((cx % cells_u + cells_u) % cells_u, (cy % cells_v + cells_v) % cells_v, salt);
  };
  return mix(mix(at(x0, y0), at(x0 + 1, y0), tx), mix(at(x0, y0 + 1), at(x0 + 1, y0 + 1), tx), ty);
}

float layered_noise(float u, float v, int cells_u, int cells_v, int layers, int salt) {
  float sum = 0, weight = 0.5f, total = 0;
  for (int i = 0; i < layers; ++i) {
    sum += weight * noise(u, v, cells_u << i, cells_v << i, salt + i);
    total += weight;
    weight *= 0.5f;
  }
  return sum / total;
}

struct Texel {
  float r, g, b;  // sRGB, 0 to 1
  float roughness;
  float height_m;
};
using TexelAt = std::function<Texel(float u, float v)>;  // v grows upwards

uint8_t to_byte(float x) {
  return static_cast<uint8_t>(std::lround(std::clamp(x, 0.0f, 1.0f) * 255));
}

Image blank(int size) {
  Image image{size, size, {}};
  image.rgb.resize(static_cast<size_t>(size) * static_cast<size_t>(size) * 3);
  return image;
}

SurfaceImages sample(int size, float side_m, const TexelAt& surface) {
  SurfaceImages images{blank(size), blank(size), blank(size)};
  const auto n = static_cast<size_t>(size);
  std::vector<float> heights(n * n);
  for (size_t row = 0; row < n; ++row) {
    for (size_t column = 0; column < n; ++column) {
      const float u = (static_cast<float>(column) + 0.5f) / static_cast<float>(size);
      const float v = 1 - (static_cast<float>(row) + 0.5f) / static_cast<float>(size);
      const Texel texel = surface(u, v);
      const size_t at = row * n + column;
      heights[at] = texel.height_m;
      images.base_color.rgb[at * 3 + 0] = to_byte(texel.r);
      images.base_color.rgb[at * 3 + 1] = to_byte(texel.g);
      images.base_color.rgb[at * 3 + 2] = to_byte(texel.b);
      images.metallic_roughness.rgb[at * 3 + 0] = 255;  // red channel, free for occlusion
      images.metallic_roughness.rgb[at * 3 + 1] = to_byte(texel.roughness);
      images.metallic_roughness.rgb[at * 3 + 2] = 0;
    }
  }
  const float texel_m = side_m / static_cast<float>(size);
  for (size_t row = 0; row < n; ++row) {
    for (size_t column = 0; column < n; ++column) {
      const float left = heights[row * n + (column + n - 1) % n], right = heights[row * n + (column + 1) % n];
      const float above = heights[(row + n - 1) % n * n + column],
                  below = heights[(row + 1) % n * n + column];
      const float x = (left - right) / (2 * texel_m), y = (below - above) / (2 * texel_m);
      const float scale = 0.5f / std::sqrt(x * x + y * y + 1);
      const size_t at = (row * n + column) * 3;
      images.normal.rgb[at + 0] = to_byte(0.5f + x * scale);
      images.normal.rgb[at + 1] = to_byte(0.5f + y * scale);
      images.normal.rgb[at + 2] = to_byte(0.5f + scale);
    }
  }
  return images;
}

Texel floor_texel(float u, float v) {
  constexpr int kTiles = 8;
  const float x = u * kTiles, y = v * kTiles;
  const int tile_x = static_cast<int>(x), tile_y = static_cast<int>(y);
  const float fx = x - static_cast<float>(tile_x), fy = y - static_cast<float>(tile_y);
  const float to_edge = std::min(std::min(fx, 1 - fx), std::min(fy, 1 - fy));
  const float on_tile = step_between(0.008f, 0.022f, to_edge);
  const float own = hash01(tile_x, tile_y, 11) - 0.5f;
  const float clouds = layered_noise(u, v, 12, 12, 5, 100 + (tile_x * 7 + tile_y * 3) % 5) - 0.5f;
  const float specks = noise(u, v, 512, 512, 40) - 0.5f;
  const bool dark = (tile_x + tile_y) % 2 == 0;
  const float tone = (dark ? 0.43f : 0.61f) + 0.055f * own + 0.13f * clouds + 0.03f * specks;
  const float grout = 0.25f + 0.06f * specks;
  const float warm = 0.015f * own;
  return {mix(grout, tone * 0.97f + warm, on_tile), mix(grout, tone, on_tile),
          mix(grout, tone * 1.05f - warm, on_tile), mix(0.95f, 0.40f + 0.28f * clouds + 0.06f * own, on_tile),
          0.0022f * step_between(0.006f, 0.03f, to_edge) + 0.0005f * clouds + 0.0001f * specks};
}

Texel wood_texel(float u, float v) {
  const float bend = layered_noise(u, v, 2, 4, 3, 7);
  const float rings = 0.5f + 0.5f * std::sin(6.2831853f * (6 * v + 1.6f * bend));
  const float fibres = layered_noise(u, v, 6, 96, 3, 23);
  const float pores = step_between(0.70f, 0.86f, noise(u, v, 20, 256, 31));
  const float dark = std::clamp(0.50f * rings * rings + 0.42f * fibres - 0.06f, 0.0f, 1.0f);
  const float shade = 1 - 0.22f * pores;
  return {mix(0.86f, 0.60f, dark) * shade, mix(0.68f, 0.40f, dark) * shade, mix(0.45f, 0.21f, dark) * shade,
          0.46f + 0.16f * fibres + 0.2f * pores, 0.00016f * (1 - pores) - 0.00012f * fibres};
}

}  // namespace

SurfaceImages make_floor_images(int size) {
  return sample(size, kFloorTile_m, floor_texel);
}
SurfaceImages make_wood_images(int size) {
  return sample(size, kWoodTile_m, wood_texel);
}

std::optional<std::vector<uint8_t>> encode_png(const Image& image) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGB;
  png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::vector<uint8_t> out(bytes);
  if (!png_image_write_to_memory(&png, out.data(), &bytes, 0, image.rgb.data(), 0, nullptr))
    return std::nullopt;
  out.resize(bytes);
  return out;
}

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
