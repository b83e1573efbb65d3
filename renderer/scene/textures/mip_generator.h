// Mip level generator. Texels are box-filtered in linear light for sRGB textures, with polyphase weights for
// odd sizes (Guthe and Heckbert, Non-Power-of-Two Mipmapping, 2005).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// Returns levels 1, 2, ... down to one texel: 8-bit RGBA, top row first, tightly packed. Level k has max(side
// >> k, 1) texels per side. srgb applies to red, green and blue. Runs on all cores.
std::vector<std::vector<uint8_t>> generate_mip_levels(const Image& image, bool srgb);

}  // namespace fire3dv::scene
