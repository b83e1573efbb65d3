// Draw settings of the path tracer, and the progress of its images.
#pragma once

#include <cstdint>

#include "renderer/scene/model/appearance.h"
#include "renderer/settings/shadow_settings.h"

namespace fire3dv::settings {

struct PathSettings {
  uint32_t samples_per_pixel = 256;
  uint32_t bounces = 8;  // after the first surface; 0: direct light
  uint32_t seed = 0;
  scene::ThinLens lens;                     // see lens_of()
  RayBackEnd back_end = RayBackEnd::query;  // preferred; the other one is the fallback
  // Work of one dispatch; 0: chosen by the device. Without influence on the image.
  uint32_t pixels_per_dispatch = 0;
  uint32_t segments_per_dispatch = 0;  // rays of each path
  bool operator==(const PathSettings&) const = default;
};

// Samples of each pixel of an image.
struct PathProgress {
  uint32_t samples = 0, samples_per_pixel = 0;  // traced; wanted
  bool is_whole() const { return samples >= samples_per_pixel; }
};

}  // namespace fire3dv::settings
