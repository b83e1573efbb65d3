// The materials of the benchmark's scenes: 32 of different colours over eight sets of textures (base colour,
// normal, metallic and roughness), all made here.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/scene/scene.h"

namespace fire3dv::bench {

constexpr uint32_t kMaterials = 32;  // beside the ground's

struct Surfaces {
  std::vector<scene::Image> images;
  std::vector<scene::Texture> textures;
  std::vector<scene::Material> materials;  // [0] is the default one, [1] the ground's, then the bodies'
};

// side: of each texture, in pixels; 0: no textures.
Surfaces make_surfaces(uint32_t side);

}  // namespace fire3dv::bench
