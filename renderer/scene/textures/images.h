// Images of textures: decoder of image files to 8-bit RGBA, and generator of mip levels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

struct EncodedImage {
  std::string name;   // name of the decoded image
  std::string where;  // for messages, for example "images[2]"
  std::span<const std::byte> bytes;
  std::string read_error;                  // not empty: why there are no bytes
  bool is_color = false, is_data = false;  // its uses by textures, as in Texture::srgb
};

struct ImageLimits {
  uint64_t max_pixels = UINT64_MAX;  // per image
  // As in LoadLimits. reserve is called once, with the bytes of all images.
  std::function<Result<void>(uint64_t bytes)> reserve = {};
  std::function<bool()> stop_requested = {};
};

struct DecodedImages {
  std::vector<Image> images;         // one per encoded image
  std::vector<bool> is_placeholder;  // one per encoded image
  std::vector<std::string> warnings;
};

// Decodes on all cores; `progress` runs on the calling thread. The format is recognised by the first bytes.
// An image that cannot be read, is broken or has too many pixels becomes a placeholder, with a warning.
// Errors are limits on all images together, a refused reservation, exhausted memory and a stopped load;
// header sizes are checked before any image is decoded.
Result<DecodedImages> decode_images(std::span<const EncodedImage> encoded, const ImageLimits& limits,
                                    const std::function<void(size_t done)>& progress);

// Opaque checker of magenta and black, the common sign of a missing texture: 8 x 8 squares of 8 x 8 texels.
Image placeholder_image(const std::string& name);

// Returns levels 1, 2, ... down to one texel: 8-bit RGBA, top row first, tightly packed. Level k has max(side
// >> k, 1) texels per side. srgb applies to red, green and blue. Runs on all cores. Texels are
// box-filtered in linear light for sRGB textures, with polyphase weights for odd sizes (Guthe and Heckbert,
// Non-Power-of-Two Mipmapping, 2005).
std::vector<std::vector<uint8_t>> generate_mip_levels(const Image& image, bool srgb);

}  // namespace fire3dv::scene
