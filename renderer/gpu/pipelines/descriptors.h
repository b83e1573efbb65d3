// Descriptor sets: those of one pass, with few fixed bindings, and the bindless set of a scene's textures.
#pragma once

#include <array>
#include <span>

#include "renderer/gpu/device/device.h"
#include "shaders/shared/bindings.h"

namespace fire3dv::gpu {

SetLayout create_set_layout(Device& device, std::span<const VkDescriptorSetLayoutBinding> bindings);
DescriptorPool create_descriptor_pool(Device& device, uint32_t sets,
                                      std::span<const VkDescriptorPoolSize> sizes);
VkDescriptorSet allocate_set(Device& device, VkDescriptorPool pool, VkDescriptorSetLayout layout);

// One descriptor set and its pool. Assignment replaces it; the old set retires after the frames that used it.
class DescriptorSet {
 public:
  DescriptorSet() = default;
  DescriptorSet(Device& device, VkDescriptorSetLayout layout, std::span<const VkDescriptorPoolSize> sizes)
      : pool_(create_descriptor_pool(device, 1, sizes)), set_(allocate_set(device, pool_.get(), layout)) {}

  const VkDescriptorSet& get() const { return set_; }

 private:
  DescriptorPool pool_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

struct SampledTexture {
  VkImageView view = VK_NULL_HANDLE;
  VkSampler sampler = VK_NULL_HANDLE;
};

using EnvironmentTextures =
    std::array<SampledTexture, FIRE3DV_BINDING_TEXTURES - FIRE3DV_BINDING_ENVIRONMENT_BACKGROUND>;

// Bindless descriptor set 0, shared by all passes and worlds. It holds the scene's textures and the
// environment images. Shaders find acceleration structures by their addresses.
class BindlessTextures {
 public:
  BindlessTextures() = default;
  // layout: from create_layout, with room for the textures. environment: bindings from
  // FIRE3DV_BINDING_ENVIRONMENT_BACKGROUND on. The set does not own the objects that it points to.
  BindlessTextures(Device& device, VkDescriptorSetLayout layout, std::span<const SampledTexture> textures,
                   const EnvironmentTextures& environment);

  // Creates the set layout for pipeline layouts, before any scene is loaded. Keep capacity small: lavapipe
  // clears 256 bytes for each descriptor of a layout.
  static SetLayout create_layout(Device& device, uint32_t capacity);
  // Largest capacity that the device supports.
  static uint32_t most(const Device& device);

  VkDescriptorSet set() const { return set_; }

 private:
  DescriptorPool pool_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

}  // namespace fire3dv::gpu
