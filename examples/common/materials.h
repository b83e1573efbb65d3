// Material library of the examples' scenes, in glTF's metallic-roughness model.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace examples {

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
