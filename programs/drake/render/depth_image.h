// Depth images as Drake's client reads them: TIFF with one channel.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace fire3dv::drake {

enum class DepthFormat : uint8_t {
  float32_m,  // metres; too near: 0, too far: infinity
  uint16_mm,  // millimetres; too near: 0, too far: 65535
};

struct DepthRange {
  double min_m = 0, max_m = 0;  // depths at or outside these are too near or too far
};

// depths_m: planar depth, infinite for the background; rows from the top, width * height values.
std::string encode_depth(std::span<const float> depths_m, uint32_t width, uint32_t height,
                         const DepthRange& range, DepthFormat format);

}  // namespace fire3dv::drake
