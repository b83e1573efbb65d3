#include "renderer/gpu/pipelines/descriptors.h"

namespace fire3dv::gpu {

SetLayout create_set_layout(Device& device, std::span<const VkDescriptorSetLayoutBinding> bindings) {
  VkDescriptorSetLayoutCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  info.bindingCount = static_cast<uint32_t>(bindings.size());
  info.pBindings = bindings.data();
  VkDescriptorSetLayout layout = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateDescriptorSetLayout(device.handle(), &info, nullptr, &layout));
  return SetLayout(device, layout);
}

DescriptorPool create_descriptor_pool(Device& device, uint32_t sets,
                                      std::span<const VkDescriptorPoolSize> sizes) {
  VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  info.maxSets = sets;
  info.poolSizeCount = static_cast<uint32_t>(sizes.size());
  info.pPoolSizes = sizes.data();
  VkDescriptorPool pool = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateDescriptorPool(device.handle(), &info, nullptr, &pool));
  return DescriptorPool(device, pool);
}

VkDescriptorSet allocate_set(Device& device, VkDescriptorPool pool, VkDescriptorSetLayout layout) {
  VkDescriptorSetAllocateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  info.descriptorPool = pool;
  info.descriptorSetCount = 1;
  info.pSetLayouts = &layout;
  VkDescriptorSet set = VK_NULL_HANDLE;
  FIRE3DV_VK(vkAllocateDescriptorSets(device.handle(), &info, &set));
  return set;
}

}  // namespace fire3dv::gpu
