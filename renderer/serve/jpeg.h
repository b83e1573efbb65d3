// JPEG encoder (libjpeg) of 8-bit sRGB images.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace fire3dv::serve {

// Appends the encoded image to `file`. rgba8: width * height * 4 bytes, top row first; alpha is ignored.
// quality: 1 to 100; from 90 on colours have full resolution. Returns false if there is no memory.
bool append_jpeg(std::span<const uint8_t> rgba8, uint32_t width, uint32_t height, int quality,
                 std::vector<uint8_t>& file);

}  // namespace fire3dv::serve
