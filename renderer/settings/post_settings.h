// Draw settings of post-processing: exposure, tone mapping, FXAA, bloom, and the lens of raster images.
#pragma once

#include "renderer/scene/model/appearance.h"

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
  // True for effects that read the samples of all pixels before tone mapping.
  bool reads_samples() const { return metered || bloom > 0; }
};

}  // namespace fire3dv::settings
