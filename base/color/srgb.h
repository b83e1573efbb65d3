// Transfer function of sRGB (IEC 61966-2-1), for values from 0 to 1.
#pragma once

#include <cmath>

namespace fire3dv {

inline float linear_from_srgb(float srgb) {
  return srgb <= 0.04045f ? srgb / 12.92f : std::pow((srgb + 0.055f) / 1.055f, 2.4f);
}
inline float srgb_from_linear(float linear) {
  return linear <= 0.0031308f ? linear * 12.92f : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

}  // namespace fire3dv
