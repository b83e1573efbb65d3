// Images of textures: PNG and JPEG decoder to 8-bit RGBA, and generator of mip levels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

struct EncodedImage {
  std::string name;   // name of the decoded image
  std::string where;  // for errors, for example "images[2]"
  std::span<const std::byte> bytes;
};

struct ImageLimits {
  uint64_t max_pixels = UINT64_MAX;  // per image
  // As in LoadLimits. reserve is called once, with the bytes of all images.
  std::function<Result<void>(uint64_t bytes)> reserve = {};
  std::function<bool()> stop_requested = {};
};

// Decodes on all cores; `progress` runs on the calling thread. The header sizes of all images are checked
// against the limits first. The error is that of the first failing image in input order.
Result<std::vector<Image>> decode_images(std::span<const EncodedImage> encoded, const ImageLimits& limits,
                                         const std::function<void(size_t done)>& progress);

// Returns levels 1, 2, ... down to one texel: 8-bit RGBA, top row first, tightly packed. Level k has max(side
// >> k, 1) texels per side. srgb applies to red, green and blue. Runs on all cores. Texels are
// box-filtered in linear light for sRGB textures, with polyphase weights for odd sizes (Guthe and Heckbert,
// Non-Power-of-Two Mipmapping, 2005).
std::vector<std::vector<uint8_t>> generate_mip_levels(const Image& image, bool srgb);

}  // namespace fire3dv::scene
