#include "renderer/gpu/pipelines/descriptors.h"

#include <algorithm>
#include <string>

namespace fire3dv::gpu {
namespace {

// See PipelineKeeper.
std::string describe(std::span<const VkDescriptorSetLayoutBinding> bindings,
                     std::span<const VkDescriptorBindingFlags> flags = {}) {
  std::string text;
  for (size_t i = 0; i < bindings.size(); ++i) {
    const VkDescriptorSetLayoutBinding& b = bindings[i];
    FIRE3DV_ASSERT(!b.pImmutableSamplers);
    for (const uint32_t number : {b.binding, static_cast<uint32_t>(b.descriptorType), b.descriptorCount,
                                  b.stageFlags, flags.empty() ? 0 : flags[i]})
      text += std::to_string(number) + ' ';
  }
  return text;
}

constexpr VkShaderStageFlags kStages = VK_SHADER_STAGE_FRAGMENT_BIT | VK_SHADER_STAGE_COMPUTE_BIT;
constexpr VkShaderStageFlags kRayStages =
    VK_SHADER_STAGE_RAYGEN_BIT_KHR | VK_SHADER_STAGE_ANY_HIT_BIT_KHR | VK_SHADER_STAGE_MISS_BIT_KHR;

}  // namespace

SetLayout create_set_layout(Device& device, std::span<const VkDescriptorSetLayoutBinding> bindings) {
  VkDescriptorSetLayoutCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  info.bindingCount = static_cast<uint32_t>(bindings.size());
  info.pBindings = bindings.data();
  VkDescriptorSetLayout layout = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateDescriptorSetLayout(device.handle(), &info, nullptr, &layout));
  device.pipeline_keeper().describe(layout, describe(bindings));
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

// Desktop drivers and lavapipe support 1 M descriptors.
uint32_t BindlessTextures::most(const Device& device) {
  VkPhysicalDeviceVulkan12Properties properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES};
  VkPhysicalDeviceProperties2 chain{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &properties};
  vkGetPhysicalDeviceProperties2(device.physical(), &chain);
  return std::min({1u << 20, properties.maxPerStageDescriptorUpdateAfterBindSampledImages - 8,
                   properties.maxPerStageDescriptorUpdateAfterBindSamplers - 8,
                   properties.maxDescriptorSetUpdateAfterBindSampledImages - 8,
                   properties.maxDescriptorSetUpdateAfterBindSamplers - 8,
                   properties.maxPerStageUpdateAfterBindResources - 64});
}

SetLayout BindlessTextures::create_layout(Device& device, uint32_t capacity) {
  std::vector<VkDescriptorSetLayoutBinding> bindings;
  std::vector<VkDescriptorBindingFlags> flags;
  const VkShaderStageFlags stages = kStages | (device.report().ray_tracing_pipeline ? kRayStages : 0);
  for (uint32_t i = 0; i < std::tuple_size_v<EnvironmentTextures>; ++i) {
    bindings.push_back({FIRE3DV_BINDING_ENVIRONMENT_BACKGROUND + i, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                        1, stages, nullptr});
    flags.push_back(0);
  }
  bindings.push_back({FIRE3DV_BINDING_TEXTURES, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                      std::min(capacity, most(device)), stages, nullptr});
  flags.push_back(VK_DESCRIPTOR_BINDING_PARTIALLY_BOUND_BIT | VK_DESCRIPTOR_BINDING_UPDATE_AFTER_BIND_BIT |
                  VK_DESCRIPTOR_BINDING_VARIABLE_DESCRIPTOR_COUNT_BIT);

  VkDescriptorSetLayoutBindingFlagsCreateInfo flag_info{
      VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_BINDING_FLAGS_CREATE_INFO};
  flag_info.bindingCount = static_cast<uint32_t>(flags.size());
  flag_info.pBindingFlags = flags.data();
  VkDescriptorSetLayoutCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, &flag_info};
  info.flags = VK_DESCRIPTOR_SET_LAYOUT_CREATE_UPDATE_AFTER_BIND_POOL_BIT;
  info.bindingCount = static_cast<uint32_t>(bindings.size());
  info.pBindings = bindings.data();
  VkDescriptorSetLayout layout = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateDescriptorSetLayout(device.handle(), &info, nullptr, &layout));
  device.pipeline_keeper().describe(layout, describe(bindings, flags));
  return SetLayout(device, layout);
}

BindlessTextures::BindlessTextures(Device& device, VkDescriptorSetLayout layout,
                                   std::span<const SampledTexture> textures,
                                   const EnvironmentTextures& environment) {
  const uint32_t count = std::max<uint32_t>(1, static_cast<uint32_t>(textures.size()));
  std::vector<VkDescriptorPoolSize> sizes{
      {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, count + static_cast<uint32_t>(environment.size())}};
  VkDescriptorPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool_info.flags = VK_DESCRIPTOR_POOL_CREATE_UPDATE_AFTER_BIND_BIT;
  pool_info.maxSets = 1;
  pool_info.poolSizeCount = static_cast<uint32_t>(sizes.size());
  pool_info.pPoolSizes = sizes.data();
  VkDescriptorPool pool = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateDescriptorPool(device.handle(), &pool_info, nullptr, &pool));
  pool_ = DescriptorPool(device, pool);

  VkDescriptorSetVariableDescriptorCountAllocateInfo variable{
      VK_STRUCTURE_TYPE_DESCRIPTOR_SET_VARIABLE_DESCRIPTOR_COUNT_ALLOCATE_INFO};
  variable.descriptorSetCount = 1;
  variable.pDescriptorCounts = &count;
  VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, &variable};
  allocate.descriptorPool = pool;
  allocate.descriptorSetCount = 1;
  allocate.pSetLayouts = &layout;
  FIRE3DV_VK(vkAllocateDescriptorSets(device.handle(), &allocate, &set_));

  std::vector<VkDescriptorImageInfo> images;
  for (const std::span<const SampledTexture> from :
       {std::span<const SampledTexture>(environment), textures}) {
    for (const SampledTexture& texture : from) {
      images.push_back({texture.sampler, texture.view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL});
    }
  }
  std::vector<VkWriteDescriptorSet> writes;
  auto write_images = [&](uint32_t binding, uint32_t first, uint32_t image_count) {
    VkWriteDescriptorSet& write =
        writes.emplace_back(VkWriteDescriptorSet{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET});
    write.dstSet = set_;
    write.dstBinding = binding;
    write.descriptorCount = image_count;
    write.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    write.pImageInfo = images.data() + first;
  };
  const auto fixed = static_cast<uint32_t>(environment.size());
  for (uint32_t i = 0; i < fixed; ++i) write_images(FIRE3DV_BINDING_ENVIRONMENT_BACKGROUND + i, i, 1);
  if (!textures.empty())
    write_images(FIRE3DV_BINDING_TEXTURES, fixed, static_cast<uint32_t>(textures.size()));
  vkUpdateDescriptorSets(device.handle(), static_cast<uint32_t>(writes.size()), writes.data(), 0, nullptr);
}

}  // namespace fire3dv::gpu
