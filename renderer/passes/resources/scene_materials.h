// Appearance data of a scene on the GPU: records of materials and lights, images and samplers.
#pragma once

#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "renderer/gpu/device/resources.h"
#include "renderer/gpu/loader_commands.h"
#include "renderer/gpu/pipelines/descriptors.h"
#include "renderer/scene/model/scene.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

struct MaterialRecords {
  std::vector<gpu_types::MaterialRecord> materials;
  std::vector<gpu_types::MaterialExtensionRecord> extensions;  // of materials with extensions
};
bool any_extended(std::span<const scene::Material> materials);
bool any_textured(std::span<const scene::Material> materials);
bool any_second_uv(std::span<const scene::Material> materials);       // true if a texture uses it
uint32_t optional_flags(std::span<const scene::Material> materials);  // of FIRE3DV_MATERIAL_OPTIONAL
// Facts about textures that material records contain.
struct TextureFacts {
  std::vector<glm::uvec2> sizes;  // by texture index; missing entries count as one texel
  bool anisotropic = false;       // smooth samplers filter anisotropically
};
TextureFacts texture_facts(const scene::Scene& scene, bool anisotropic);
MaterialRecords material_records(std::span<const scene::Material> materials,
                                 const TextureFacts& textures = {});
gpu_types::LightRecord light_record(const scene::Light& light, uint32_t node);

// An image of the device, shared by the scenes that follow each other.
struct SharedTexture {
  std::weak_ptr<const void> pixels;  // identity of the image's
  bool srgb = false;
  std::shared_ptr<gpu::Image> image;
};

struct SceneTextures {
  std::vector<SharedTexture> images;         // one for each use of an image as colour or as data
  std::vector<gpu::Sampler> samplers;        // one for each distinct description
  std::vector<gpu::SampledTexture> sampled;  // one per scene.textures entry; refers to images and samplers
};

// Batched texture upload that overlaps with other loading work on the host. The scene must live until
// finish().
class TextureUploads {
 public:
  // before: of a scene on the same device, which must live until finish(); images of the same pixels are
  // shared with it instead of being uploaded. Null: none.
  TextureUploads(gpu::Device& device, const scene::Scene& scene, float anisotropy,
                 const SceneTextures* before);

  // Submits the next batch, of bounded size, without waiting for it. Waits for the previous batch.
  void submit_some();
  // Submits the rest and waits. Call it once.
  SceneTextures finish();

 private:
  void add(const scene::Texture& texture);
  std::shared_ptr<gpu::Image> upload(const scene::Image& source, bool srgb);
  VkSampler sampler_of(const scene::Sampler& wanted);

  gpu::Device& device_;
  const scene::Scene& scene_;
  float anisotropy_;
  gpu::LoaderCommands loader_;
  size_t next_ = 0;         // index in the scene's textures
  size_t chunk_bytes_ = 0;  // of this batch
  std::map<std::pair<uint32_t, bool>, VkImageView> views_;
  // Images of the scene before, by the address of their pixels and their use.
  std::map<std::pair<const void*, bool>, std::shared_ptr<gpu::Image>> known_;
  std::vector<std::pair<scene::Sampler, VkSampler>> samplers_;
  SceneTextures uploaded_;
};

}  // namespace fire3dv::passes
