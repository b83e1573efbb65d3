// PNG decoder to 8-bit RGB without colour management, as MuJoCo reads PNG files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/error.h"

namespace fire3dv::convert {

struct PngPixels {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> rgb;  // rows from the top
};

bool is_png_file(std::span<const std::byte> bytes);
// At most 2^26 pixels. Opacity is dropped. The error is a sentence end about the file.
Result<PngPixels> decode_png(std::span<const std::byte> bytes);

}  // namespace fire3dv::convert
