// PNG and JPEG to 8-bit RGBA.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "renderer/scene/scene.h"

namespace fire3dv::scene {

struct EncodedImage {
  std::string name;   // of the result
  std::string where;  // for errors: "images[2]"
  std::span<const std::byte> bytes;
};

// Decodes on all cores; `progress` is called on the calling one. The size in the header is checked
// against the limit before any pixel is. The error is that of the first image that fails, in the order given.
Result<std::vector<Image>> decode_images(std::span<const EncodedImage> encoded, uint64_t max_pixels,
                                         const std::function<void(size_t done)>& progress);

}  // namespace fire3dv::scene
