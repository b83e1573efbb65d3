// What things are made of.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace examples {

enum class Surface { plain, floor, wood };

struct Material {
  std::string name;
  std::array<float, 3> base_color;  // linear; multiplies the surface's picture
  float metallic;
  float roughness;
  Surface surface = Surface::plain;
  std::array<float, 3> emissive{0, 0, 0};
};

std::vector<Material> make_materials();

}  // namespace examples
