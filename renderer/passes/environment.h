// What surrounds the scene, as light: prepared on the GPU once, when it is loaded, into what shading looks
// up. A cube of reflections by roughness, a cube of what matte surfaces scatter, and a table of how much
// surfaces reflect at all.
#pragma once

#include <glm/glm.hpp>

#include "renderer/gpu/bindless_textures.h"
#include "renderer/gpu/resources.h"
#include "renderer/passes/view.h"
#include "renderer/scene/environment.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

// What is seen where nothing of the scene is.
struct Background {
  bool surroundings = false;
  glm::vec3 color{0.16f, 0.18f, 0.21f};  // linear, when they do not show
};

class Environment {
 public:
  Environment(gpu::Device& device, const scene::EnvironmentImage& image);

  gpu::EnvironmentTextures textures() const;
  // The look-ups' share of the frame's numbers.
  void describe(gpu_types::Globals& globals, float intensity, float rotation_rad) const;
  // Of the picture, for a background that neither flickers nor blurs. At least 0.
  float picture_level(const View& view, uint32_t image_height) const;

 private:
  float scale_;
  gpu::Image picture_, specular_, irradiance_, albedo_;
  gpu::Sampler picture_sampler_, map_sampler_;
};

}  // namespace fire3dv::passes
