// Material library of the examples' scenes, in glTF's metallic-roughness model, with procedural textures:
// seamless tiles without asset files.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace examples {

// RGB image, rows from the top.
struct Image {
  int width = 0, height = 0;
  std::vector<uint8_t> rgb;
};

// Textures of a surface in glTF's layout: base colour (sRGB), roughness in G and metalness in B,
// tangent-space normal.
struct SurfaceImages {
  Image base_color;
  Image metallic_roughness;
  Image normal;
};

constexpr float kFloorTile_m = 2.0f;  // side of the tile
constexpr float kWoodTile_m = 0.32f;

SurfaceImages make_floor_images(int size);
SurfaceImages make_wood_images(int size);

// Returns nothing when libpng fails.
std::optional<std::vector<uint8_t>> encode_png(const Image& image);

enum class Surface { plain, floor, wood };

struct Material {
  std::string name;
  std::array<float, 3> base_color;  // linear; multiplied with the texture of the surface
  float metallic;
  float roughness;
  Surface surface = Surface::plain;
  std::array<float, 3> emissive{0, 0, 0};
};

std::vector<Material> make_materials();

}  // namespace examples
