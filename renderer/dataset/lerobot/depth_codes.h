// Depth as codes of 12 bits, as LeRobot stores it in videos (lerobot.datasets.depth_utils, version 0.6).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/dataset/labels/description.h"

namespace fire3dv::dataset {

constexpr uint16_t kMaxDepthCode = 4095;

// Code 0 is min_m and 4095 is max_m; the logarithm of depth + shift, or the depth itself, is in equal steps.
struct DepthCodes {
  double min_m = 0.01, max_m = 10, shift_m = 3.5;  // LeRobot's defaults
  bool is_logarithmic = true;

  // Steps of depth_unit_mm from 0 m, if the description has linear depth.
  static DepthCodes of(const Description& description);
  // Depth beyond the range has the nearest code; infinity, which is no surface, has 4095.
  std::vector<uint16_t> encode(std::span<const float> depth_m) const;
  double decode(uint16_t code) const;  // metres
};

}  // namespace fire3dv::dataset
