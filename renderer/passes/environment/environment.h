// Environment maps for image-based lighting: prefiltered specular cube, irradiance cube and albedo table. The
// GPU prepares them once; later starts read them from the cache.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "base/digest.h"
#include "renderer/gpu/device/device.h"
#include "renderer/gpu/device/resources.h"
#include "renderer/gpu/loader_commands.h"
#include "renderer/gpu/pipelines/descriptors.h"
#include "renderer/passes/environment/environment_store.h"
#include "renderer/passes/view/view.h"
#include "renderer/scene/textures/environment.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

// Cache key of environment maps: image, device, driver, shaders and the recipe with all other parameters.
Digest environment_kind(const VkPhysicalDeviceProperties& device, const scene::EnvironmentImage& image,
                        std::span<const uint32_t> recipe);

// Mip level of an equirectangular image behind a view: without aliasing or blur. At least 0.
float equirectangular_level(const View& view, uint32_t image_height, uint32_t texels_high);

class Environment {
 public:
  // image: the background. lighting: the image of the prefiltered maps, without the sun where that is a
  // light. cache: cache of the prepared maps, read and filled; null: no cache.
  Environment(gpu::Device& device, const scene::EnvironmentImage& image,
              const scene::EnvironmentImage& lighting, EnvironmentStore* cache);

  gpu::EnvironmentTextures textures() const;
  // Fills the environment's part of the frame globals.
  void describe(gpu_types::Globals& globals, float intensity, float rotation_rad) const;
  // Mip level of the environment image for a background without aliasing or blur. At least 0.
  float background_level(const View& view, uint32_t image_height) const;

 private:
  // One level of the maps, in cache order.
  struct Level {
    gpu::Image* image;
    uint32_t level;
    size_t bytes;
  };
  // Parameters of the preparation.
  struct Recipe {
    uint32_t face = 0;             // texels along a face of the sharpest reflection
    uint32_t radiance_levels = 0;  // of the source radiance cube
    uint32_t irradiance_from = 0;  // source level for irradiance
    gpu_types::EnvironmentPush cube{}, albedo{};
    std::vector<gpu_types::EnvironmentPush> specular;  // by level

    static Recipe of(const scene::EnvironmentImage& image);
    std::vector<uint32_t> numbers() const;  // all parameters, for the cache key
  };
  std::vector<Level> levels();
  void prepare(gpu::LoaderCommands& loader, const Recipe& recipe, gpu::Image& lighting);
  void upload(gpu::LoaderCommands& loader, std::span<const std::byte> maps);
  std::vector<std::byte> download(gpu::LoaderCommands& loader);

  gpu::Device& device_;
  float scale_;
  gpu::Image background_image_, specular_, irradiance_, albedo_;
  gpu::Sampler background_sampler_, map_sampler_;
};

}  // namespace fire3dv::passes
