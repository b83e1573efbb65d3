// Descriptor sets of one pass, with few fixed bindings. The scene's bindless set is in bindless_textures.h.
#pragma once

#include <span>

#include "renderer/gpu/device/device.h"

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

}  // namespace fire3dv::gpu
