// Value of ShadowSettings::map_side for small shadow maps.
#pragma once

#include <cstdint>

namespace fire3dv::settings {

// Maps of 64 to 512 texels along a side, about as many as the image has pixels, drawn with coarse levels. For
// batches of small images: each world has maps of its own.
constexpr uint32_t kSmallMaps = 1;

}  // namespace fire3dv::settings
