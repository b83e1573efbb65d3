// The images and samplers of a scene, on the GPU.
#pragma once

#include <map>
#include <utility>
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

// Takes a scene's textures to the device in turns, so that a queue copies them while whoever
// loads the scene does something else. The scene must live until finish().
class TextureUploads {
 public:
  TextureUploads(gpu::Device& device, const scene::Scene& scene, float anisotropy)
      : device_(device), scene_(scene), anisotropy_(anisotropy), loader_(device) {}

  // Submits some that are left, of a bounded number of bytes, without waiting for them; but for those of the
  // turn before.
  void submit_some();
  // Submits all that are left and waits. Once.
  SceneTextures finish();

 private:
  void add(const scene::Texture& texture);
  VkSampler sampler_of(const scene::Sampler& wanted);

  gpu::Device& device_;
  const scene::Scene& scene_;
  float anisotropy_;
  gpu::LoaderCommands loader_;
  size_t next_ = 0;        // of the scene's textures
  size_t turn_bytes_ = 0;  // of this turn
  std::map<std::pair<uint32_t, bool>, VkImageView> views_;
  std::vector<std::pair<scene::Sampler, VkSampler>> samplers_;
  SceneTextures uploaded_;
};

}  // namespace fire3dv::passes
