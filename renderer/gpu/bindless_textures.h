// Descriptor set 0, the same for every pass: the scene's textures, indexed by the shader, the images of its
// surroundings, and the top-level acceleration structure where the device has ray queries.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "renderer/gpu/device.h"
#include "shaders/shared/bindings.h"

namespace fire3dv::gpu {

struct SampledTexture {
  VkImageView view = VK_NULL_HANDLE;
  VkSampler sampler = VK_NULL_HANDLE;
};

using EnvironmentTextures =
    std::array<SampledTexture, FIRE3DV_BINDING_TEXTURES - FIRE3DV_BINDING_ENVIRONMENT_PICTURE>;

class BindlessTextures {
 public:
  BindlessTextures() = default;
  // layout: from create_layout, with room for the textures. environment: from
  // FIRE3DV_BINDING_ENVIRONMENT_PICTURE on. top_level may be VK_NULL_HANDLE. The set does not own what it
  // points to.
  BindlessTextures(Device& device, VkDescriptorSetLayout layout, std::span<const SampledTexture> textures,
                   const EnvironmentTextures& environment, VkAccelerationStructureKHR top_level);

  // For pipeline layouts, which are made before any scene. lavapipe clears memory for all that a layout has
  // room for, 256 bytes each, so there is no more room than scenes have use for.
  static SetLayout create_layout(Device& device, uint32_t capacity);
  // What a device can have.
  static uint32_t most(const Device& device);

  VkDescriptorSet set() const { return set_; }

 private:
  DescriptorPool pool_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

}  // namespace fire3dv::gpu
