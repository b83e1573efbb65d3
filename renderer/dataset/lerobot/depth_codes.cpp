#include "renderer/dataset/lerobot/depth_codes.h"

#include <algorithm>
#include <cmath>

namespace fire3dv::dataset {

DepthCodes DepthCodes::of(const Description& description) {
  if (!description.episode.has_linear_depth) return {};
  return {0, kMaxDepthCode * description.depth_unit_mm / kMillimetres, 0, false};
}

std::vector<uint16_t> DepthCodes::encode(std::span<const float> depth_m) const {
  const auto scaled = [&](double m) { return is_logarithmic ? std::log(m + shift_m) : m; };
  const double low = scaled(min_m), codes_per_unit = kMaxDepthCode / (scaled(max_m) - low);
  std::vector<uint16_t> codes;
  codes.reserve(depth_m.size());
  for (const float depth : depth_m) {
    const double m = depth >= 0 ? std::min(double{depth}, max_m) : min_m;  // not a number: too near
    const double code = std::nearbyint((scaled(m) - low) * codes_per_unit);
    codes.push_back(static_cast<uint16_t>(std::clamp(code, 0.0, double{kMaxDepthCode})));
  }
  return codes;
}

double DepthCodes::decode(uint16_t code) const {
  const auto scaled = [&](double m) { return is_logarithmic ? std::log(m + shift_m) : m; };
  const double low = scaled(min_m), value = low + code * (scaled(max_m) - low) / kMaxDepthCode;
  return std::clamp(is_logarithmic ? std::exp(value) - shift_m : value, min_m, max_m);
}

}  // namespace fire3dv::dataset
