// Decoders of image files in memory to 8-bit RGBA: PNG and JPEG (stb_image), WebP (libwebp), KTX 2.0
// (ktx2/). Errors are sentences about
// "it", the image, without its name. std::bad_alloc means exhausted memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

enum class ImageFormat { png_or_jpeg, webp, ktx2 };

struct ImageHeader {
  ImageFormat format = ImageFormat::png_or_jpeg;
  uint32_t width = 0, height = 0;  // at least 1
  std::optional<bool> is_srgb;     // what the file states: sRGB or linear
  std::vector<std::string> notes;  // deviations from what glTF allows, for warnings

  uint64_t pixels() const { return uint64_t{width} * height; }
};

// Recognises the format by the first bytes and reads the size, without decoding.
Result<ImageHeader> read_image_header(std::span<const std::byte> bytes);

// header: what read_image_header() returned for these bytes. The result has its size and no name.
Result<Image> decode_image(const ImageHeader& header, std::span<const std::byte> bytes);

}  // namespace fire3dv::scene
