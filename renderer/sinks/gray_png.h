// Decoder of grey PNG files with 16 bits, which decode_png() reduces to 8.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace fire3dv::sinks {

struct Gray16 {
  uint32_t width = 0, height = 0;
  std::vector<uint16_t> pixels;  // rows from the top
};

// Untrusted bytes, which decode_png() has accepted. nullopt: another type, interlaced, or larger than
// max_pixels.
std::optional<Gray16> decode_gray16(std::span<const uint8_t> png, uint64_t max_pixels);

}  // namespace fire3dv::sinks
