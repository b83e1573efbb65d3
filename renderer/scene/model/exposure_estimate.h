// Exposure estimate from a scene's lights and emissive surfaces, without an image: the same for every frame,
// so that an image drawn alone equals the same image of a sequence.
#pragma once

#include <functional>
#include <glm/glm.hpp>

#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

struct ExposureEstimate {
  float illuminance_lux = 0;  // of the scene's lights, without shadows; see estimate_exposure()
  float radiance = 0;         // mean of a half-white diffuse surface and of emissive surfaces
  float exposure = 1;         // factor on linear colour; 1 within the usual range
};

// Camera, as far as it decides which surfaces an image shows.
struct SeenFrom {
  glm::mat4 clip_from_world{1};
  glm::vec4 eye_world{0, 0, 0, 1};  // w 0: the direction towards an orthographic camera
};

// environment_radiance: mean over all directions, with the intensity factor applied.
// default_view: of the scene, called if lamps are inside the scene's bounds. Such a lamp counts with the mean
// illuminance of the surfaces that this view shows: a lamp in a shade lights little of what the camera sees,
// a ceiling lamp lights the whole room. All other lights count with the illuminance of a surface at the
// scene's centre that faces them.
ExposureEstimate estimate_exposure(const Scene& scene, float environment_radiance,
                                   const std::function<SeenFrom()>& default_view);

}  // namespace fire3dv::scene
