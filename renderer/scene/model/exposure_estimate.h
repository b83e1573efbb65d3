// Exposure estimate from a scene's lights and emissive surfaces, without an image: the same for every frame,
// so that an image drawn alone equals the same image of a sequence.
#pragma once

#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

struct ExposureEstimate {
  float illuminance_lux = 0;  // of the scene's lights at its centre, without shadows
  float radiance = 0;         // mean of a half-white diffuse surface and of emissive surfaces
  float exposure = 1;         // factor on linear colour; 1 within the usual range
};

// environment_radiance: mean over all directions, with the intensity factor applied.
ExposureEstimate estimate_exposure(const Scene& scene, float environment_radiance);

}  // namespace fire3dv::scene
