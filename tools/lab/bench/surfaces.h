// Procedural materials of the benchmark scenes: 32 colours over eight texture sets (base colour, normal,
// metallic-roughness).
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/scene/model/scene.h"

namespace fire3dv::bench {

constexpr uint32_t kMaterials = 32;  // without the ground's

struct Surfaces {
  std::vector<scene::Image> images;
  std::vector<scene::Texture> textures;
  std::vector<scene::Material> materials;  // [0] default, [1] ground, then bodies
};

// side: texture size in pixels; 0: no textures.
Surfaces make_surfaces(uint32_t side);

}  // namespace fire3dv::bench
