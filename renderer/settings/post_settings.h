// Draw settings of post-processing: exposure, tone mapping, FXAA, bloom, the lens of raster images, optics
// and sensor.
#pragma once

#include "renderer/scene/model/appearance.h"
#include "renderer/settings/optics_settings.h"

namespace fire3dv::settings {

enum class ToneMap { reinhard, aces, neutral, none };

struct PostSettings {
  float exposure = 1;
  bool metered = false;    // exposure by the light of each image; `exposure` is for images without
  bool estimated = false;  // exposure by the lights of the scene, which set_exposure() computes
  ToneMap tone_map = ToneMap::reinhard;
  float saturation = 1;  // of scene-referred colours after tone mapping; 0: grey
  bool fxaa = true;
  float bloom = 0;       // share of blurred light, 0 to 1; 0: no bloom passes
  scene::ThinLens lens;  // of rasterised images, see lens_of()
  OpticsSettings optics;
  // True for effects that read the samples of all pixels before tone mapping.
  bool reads_samples() const { return metered || bloom > 0 || optics.any(); }
};

}  // namespace fire3dv::settings
