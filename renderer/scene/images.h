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

struct ImageLimits {
  uint64_t max_pixels = UINT64_MAX;  // of one image
  // As in LoadLimits. reserve: called once, with the bytes of all images together.
  std::function<Result<void>(uint64_t bytes)> reserve = {};
  std::function<bool()> stop_requested = {};
};

// Decodes on all cores; `progress` is called on the calling thread. The sizes in the headers of all images
// are checked against the limits before any pixel is decoded. The error is that of the first image that
// fails, in the order given.
Result<std::vector<Image>> decode_images(std::span<const EncodedImage> encoded, const ImageLimits& limits,
                                         const std::function<void(size_t done)>& progress);

}  // namespace fire3dv::scene
