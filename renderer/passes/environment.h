// What surrounds the scene, as light: prepared on the GPU once, when it is loaded or the first time that it
// is, into what shading looks up. A cube of reflections by roughness, a cube of what matte surfaces scatter,
// and a table of how much surfaces reflect at all.
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/gpu/bindless_textures.h"
#include "renderer/gpu/loader_commands.h"
#include "renderer/gpu/resources.h"
#include "renderer/passes/kept_environment.h"
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
  // kept: who may have what it is prepared into, and else is given it; null: nobody.
  Environment(gpu::Device& device, const scene::EnvironmentImage& image, EnvironmentStore* kept);

  gpu::EnvironmentTextures textures() const;
  // The look-ups' share of the frame's numbers.
  void describe(gpu_types::Globals& globals, float intensity, float rotation_rad) const;
  // Of the picture, for a background that neither flickers nor blurs. At least 0.
  float picture_level(const View& view, uint32_t image_height) const;

 private:
  // Of the maps, in the order in which they are kept.
  struct Level {
    gpu::Image* image;
    uint32_t level;
    size_t bytes;
  };
  // How they are made.
  struct Recipe {
    uint32_t face = 0;             // texels along one of the sharpest reflections
    uint32_t radiance_levels = 0;  // of the cube that all is made of
    uint32_t irradiance_from = 0;  // level of that
    gpu_types::EnvironmentPush cube{}, albedo{};
    std::vector<gpu_types::EnvironmentPush> specular;  // by level

    static Recipe of(const scene::EnvironmentImage& image);
    std::vector<uint32_t> numbers() const;  // all of them
  };
  std::vector<Level> levels();
  void prepare(gpu::LoaderCommands& loader, const Recipe& recipe);
  void upload(gpu::LoaderCommands& loader, std::span<const std::byte> maps);
  std::vector<std::byte> download(gpu::LoaderCommands& loader);

  gpu::Device& device_;
  float scale_;
  gpu::Image picture_, specular_, irradiance_, albedo_;
  gpu::Sampler picture_sampler_, map_sampler_;
};

}  // namespace fire3dv::passes
