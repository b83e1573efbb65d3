// The images and samplers of a scene, on the GPU.
#pragma once

#include <vector>

#include "renderer/gpu/bindless_textures.h"
#include "renderer/gpu/loader_commands.h"
#include "renderer/gpu/resources.h"
#include "renderer/scene/scene.h"

namespace fire3dv::passes {

struct SceneTextures {
  std::vector<gpu::Image> images;            // one for each use of an image as colour or as data
  std::vector<gpu::Sampler> samplers;        // one for each distinct description
  std::vector<gpu::SampledTexture> sampled;  // as scene.textures; refer to the other two
};

SceneTextures upload_textures(gpu::Device& device, gpu::LoaderCommands& loader, const scene::Scene& scene,
                              float anisotropy);

}  // namespace fire3dv::passes
