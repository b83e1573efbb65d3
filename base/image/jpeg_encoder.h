// JPEG encoder of 8-bit sRGB images, by libjpeg-turbo: baseline.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "base/error.h"

namespace fire3dv {

enum class Chroma : uint8_t {
  half,  // 4:2:0: colours in half the resolution
  full   // 4:4:4
};

// Keeps its buffers between images. One thread at a time.
class JpegEncoder {
 public:
  JpegEncoder();
  ~JpegEncoder();
  JpegEncoder(JpegEncoder&&) noexcept;
  JpegEncoder& operator=(JpegEncoder&&) noexcept;

  // rgbx: 4 bytes a pixel, top row first, rows of row_stride bytes; the fourth byte is ignored. quality: 1 to
  // 100. The bytes are valid until the next call.
  Result<std::span<const uint8_t>> encode(const void* rgbx, uint32_t width, uint32_t height,
                                          size_t row_stride, uint32_t quality, Chroma chroma = Chroma::half);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace fire3dv
