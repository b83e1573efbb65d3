// The smaller levels of a texture: each texel is the mean of those that it covers, as light where colours are
// sRGB, and by their shares where a side is odd (Guthe and Heckbert, Non-Power-of-Two Mipmapping, 2005).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/scene/scene.h"

namespace fire3dv::scene {

// Levels 1, 2, ... down to one texel, RGBA of 8 bits, rows from the top, tightly packed; level k has
// max(side >> k, 1) texels a side. srgb: of red, green and blue. On all cores.
std::vector<std::vector<uint8_t>> smaller_levels(const Image& image, bool srgb);

}  // namespace fire3dv::scene
