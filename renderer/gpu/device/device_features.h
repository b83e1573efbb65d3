// Device features in use, as one pNext chain. Listing devices queries the chain; creating a device enables
// it.
#pragma once

#include <string>
#include <vector>

#include "renderer/gpu/device/vk.h"

namespace fire3dv::gpu {

std::vector<VkExtensionProperties> device_extensions(VkPhysicalDevice device);
bool has_extension(const std::vector<VkExtensionProperties>& extensions, const char* name);

struct DeviceFeatures {
  VkPhysicalDeviceFeatures2 core{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
  VkPhysicalDeviceVulkan11Features vulkan11{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES};
  VkPhysicalDeviceVulkan12Features vulkan12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
  VkPhysicalDeviceVulkan13Features vulkan13{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
  VkPhysicalDeviceAccelerationStructureFeaturesKHR acceleration{
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR};
  VkPhysicalDeviceRayQueryFeaturesKHR ray_query{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR};
  VkPhysicalDeviceRayTracingPipelineFeaturesKHR ray_pipeline{
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_FEATURES_KHR};

  bool post_depth_coverage = false, memory_budget = false;  // extensions without feature structures

  DeviceFeatures() = default;
  DeviceFeatures(const DeviceFeatures&) = delete;  // the chain points into the object
  DeviceFeatures& operator=(const DeviceFeatures&) = delete;

  // Fills the structures of supported extensions, less what the device's mask hides (gpu/mask).
  void query(VkPhysicalDevice device);
  std::vector<std::string> missing_required() const;
  bool has_visible_coverage() const { return post_depth_coverage && core.features.sampleRateShading; }
  // Fragments can be sorted by depth in a buffer; see docs/design/transparency.md.
  bool has_sorted_fragments() const {
    return has_visible_coverage() && core.features.fragmentStoresAndAtomics && core.features.geometryShader &&
           vulkan12.shaderBufferInt64Atomics && vulkan12.drawIndirectCount;
  }
  bool has_ray_query() const { return acceleration.accelerationStructure && ray_query.rayQuery; }
  bool has_ray_tracing_pipeline() const {
    return acceleration.accelerationStructure && ray_pipeline.rayTracingPipeline &&
           ray_pipeline.rayTracingPipelineTraceRaysIndirect;
  }

  // Reduces the queried features to those in use, for vkCreateDevice, and lists the extensions to enable.
  VkPhysicalDeviceFeatures2* enable_chain(std::vector<const char*>& extensions);
};

}  // namespace fire3dv::gpu
