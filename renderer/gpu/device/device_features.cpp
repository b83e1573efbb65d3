#include "renderer/gpu/device/device_features.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "renderer/gpu/mask/device_mask.h"

namespace fire3dv::gpu {
namespace {

struct RequiredFeature {
  const char* name;
  VkBool32 present;
};

}  // namespace

std::vector<VkExtensionProperties> device_extensions(VkPhysicalDevice device) {
  uint32_t count = 0;
  vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr);
  std::vector<VkExtensionProperties> extensions(count);
  vkEnumerateDeviceExtensionProperties(device, nullptr, &count, extensions.data());
  std::erase_if(extensions, [](const auto& e) { return device_mask().hides_extension(e.extensionName); });
  return extensions;
}

bool has_extension(const std::vector<VkExtensionProperties>& extensions, const char* name) {
  return std::any_of(extensions.begin(), extensions.end(),
                     [&](const VkExtensionProperties& e) { return std::strcmp(e.extensionName, name) == 0; });
}

void DeviceFeatures::query(VkPhysicalDevice device) {
  const std::vector<VkExtensionProperties> extensions = device_extensions(device);
  core.pNext = &vulkan11;
  vulkan11.pNext = &vulkan12;
  vulkan12.pNext = &vulkan13;
  memory_budget = has_extension(extensions, VK_EXT_MEMORY_BUDGET_EXTENSION_NAME);
  post_depth_coverage = has_extension(extensions, VK_EXT_POST_DEPTH_COVERAGE_EXTENSION_NAME);
  void** tail = &vulkan13.pNext;
  const bool acceleration_structures =
      has_extension(extensions, VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME) &&
      has_extension(extensions, VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME);
  if (acceleration_structures) {
    *tail = &acceleration;
    tail = &acceleration.pNext;
    if (has_extension(extensions, VK_KHR_RAY_QUERY_EXTENSION_NAME)) {
      *tail = &ray_query;
      tail = &ray_query.pNext;
    }
    if (has_extension(extensions, VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME)) {
      *tail = &ray_pipeline;
      tail = &ray_pipeline.pNext;
    }
  }
  vkGetPhysicalDeviceFeatures2(device, &core);
  device_mask().apply(core.features, vulkan12);
}

std::vector<std::string> DeviceFeatures::missing_required() const {
  const RequiredFeature required[] = {
      {"dynamicRendering", vulkan13.dynamicRendering},
      {"synchronization2", vulkan13.synchronization2},
      {"maintenance4", vulkan13.maintenance4},
      {"bufferDeviceAddress", vulkan12.bufferDeviceAddress},
      {"timelineSemaphore", vulkan12.timelineSemaphore},
      {"scalarBlockLayout", vulkan12.scalarBlockLayout},
      {"hostQueryReset", vulkan12.hostQueryReset},
      {"runtimeDescriptorArray", vulkan12.runtimeDescriptorArray},
      {"descriptorBindingPartiallyBound", vulkan12.descriptorBindingPartiallyBound},
      {"descriptorBindingSampledImageUpdateAfterBind", vulkan12.descriptorBindingSampledImageUpdateAfterBind},
      {"descriptorBindingVariableDescriptorCount", vulkan12.descriptorBindingVariableDescriptorCount},
      {"shaderSampledImageArrayNonUniformIndexing", vulkan12.shaderSampledImageArrayNonUniformIndexing},
      {"multiDrawIndirect", core.features.multiDrawIndirect},
      {"drawIndirectFirstInstance", core.features.drawIndirectFirstInstance},
      {"shaderInt64", core.features.shaderInt64},
  };
  std::vector<std::string> missing;
  for (const RequiredFeature& feature : required) {
    if (!feature.present) missing.push_back(feature.name);
  }
  return missing;
}

VkPhysicalDeviceFeatures2* DeviceFeatures::enable_chain(std::vector<const char*>& extensions) {
  const VkPhysicalDeviceFeatures had = core.features;
  core.features = {};
  core.features.multiDrawIndirect = VK_TRUE;
  core.features.drawIndirectFirstInstance = VK_TRUE;
  core.features.shaderInt64 = VK_TRUE;
  core.features.samplerAnisotropy = had.samplerAnisotropy;
  core.features.shaderStorageImageMultisample = had.shaderStorageImageMultisample;
  core.features.sampleRateShading = had.sampleRateShading;
  core.features.fragmentStoresAndAtomics = had.fragmentStoresAndAtomics;
  core.features.geometryShader = had.geometryShader;  // for the number of a primitive in fragment shaders
  if (memory_budget) extensions.push_back(VK_EXT_MEMORY_BUDGET_EXTENSION_NAME);
  if (post_depth_coverage) extensions.push_back(VK_EXT_POST_DEPTH_COVERAGE_EXTENSION_NAME);
  core.features.dualSrcBlend = had.dualSrcBlend;

  vulkan11 = {vulkan11.sType, vulkan11.pNext};

  const VkPhysicalDeviceVulkan12Features had12 = vulkan12;
  vulkan12 = {had12.sType, had12.pNext};
  vulkan12.bufferDeviceAddress = VK_TRUE;
  vulkan12.timelineSemaphore = VK_TRUE;
  vulkan12.scalarBlockLayout = VK_TRUE;
  vulkan12.hostQueryReset = VK_TRUE;
  vulkan12.descriptorIndexing = had12.descriptorIndexing;
  vulkan12.runtimeDescriptorArray = VK_TRUE;
  vulkan12.descriptorBindingPartiallyBound = VK_TRUE;
  vulkan12.descriptorBindingSampledImageUpdateAfterBind = VK_TRUE;
  vulkan12.descriptorBindingVariableDescriptorCount = VK_TRUE;
  vulkan12.shaderSampledImageArrayNonUniformIndexing = VK_TRUE;
  vulkan12.shaderBufferInt64Atomics = had12.shaderBufferInt64Atomics;
  vulkan12.drawIndirectCount = had12.drawIndirectCount;

  vulkan13 = {vulkan13.sType, vulkan13.pNext};
  vulkan13.dynamicRendering = VK_TRUE;
  vulkan13.synchronization2 = VK_TRUE;
  vulkan13.maintenance4 = VK_TRUE;

  if (acceleration.accelerationStructure) {
    extensions.push_back(VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME);
    extensions.push_back(VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME);
    acceleration = {acceleration.sType, acceleration.pNext};
    acceleration.accelerationStructure = VK_TRUE;
    if (ray_query.rayQuery) extensions.push_back(VK_KHR_RAY_QUERY_EXTENSION_NAME);
    if (ray_pipeline.rayTracingPipeline) {
      extensions.push_back(VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME);
      ray_pipeline = {ray_pipeline.sType, ray_pipeline.pNext};
      ray_pipeline.rayTracingPipeline = VK_TRUE;
      ray_pipeline.rayTracingPipelineTraceRaysIndirect = VK_TRUE;
    }
  } else {
    vulkan13.pNext = nullptr;  // a device with the extension but without the feature
  }
  return &core;
}

}  // namespace fire3dv::gpu
