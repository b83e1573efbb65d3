// Pictures for the scene's materials, made by arithmetic: they tile without seams and need no asset files.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace examples {

// Rows from the top, RGB.
struct Image {
  int width = 0, height = 0;
  std::vector<uint8_t> rgb;
};

// One surface as glTF wants it: base colour (sRGB), roughness in G and metalness in B, and the tangent-space
// normal.
struct SurfaceImages {
  Image base_color;
  Image metallic_roughness;
  Image normal;
};

constexpr float kFloorTile_m = 2.0f;  // the side of the area that the floor's images cover
constexpr float kWoodTile_m = 0.32f;

SurfaceImages make_floor_images(int size);
SurfaceImages make_wood_images(int size);

// Empty if libpng refuses.
std::optional<std::vector<uint8_t>> encode_png(const Image& image);

}  // namespace examples
