// Encoders of label images: grey PNG of 8 or 16 bits, and uncompressed TIFF of 16 bits. Deterministic.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace fire3dv::dataset {

// Rows from the top, without padding.
std::vector<uint8_t> encode_gray_png(std::span<const uint8_t> pixels, uint32_t width, uint32_t height);
std::vector<uint8_t> encode_gray_png(std::span<const uint16_t> pixels, uint32_t width, uint32_t height);

// channels: 1 (grey) or 3 (RGB, interleaved).
std::vector<uint8_t> encode_tiff(std::span<const uint16_t> samples, uint32_t width, uint32_t height,
                                 uint16_t channels);

}  // namespace fire3dv::dataset
