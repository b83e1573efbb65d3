// PNG and JPEG decoder to 8-bit RGBA.
#pragma once

#include <cstddef>
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

}  // namespace fire3dv::scene
