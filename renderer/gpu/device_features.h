// The device features that are used, as one chain: asked for when devices are listed, enabled when one is
// created.
#pragma once

#include <string>
#include <vector>

#include "renderer/gpu/vk.h"

namespace fire3dv::gpu {

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

  bool post_depth_coverage = false, memory_budget = false;  // extensions without structures of their own

  DeviceFeatures() = default;
  DeviceFeatures(const DeviceFeatures&) = delete;  // the chain points into the object
  DeviceFeatures& operator=(const DeviceFeatures&) = delete;

  // Links the structures whose extensions the device has; the result is for vkGetPhysicalDeviceFeatures2.
  VkPhysicalDeviceFeatures2* query_chain(VkPhysicalDevice device);
  std::vector<std::string> missing_required() const;
  bool has_visible_coverage() const { return post_depth_coverage && core.features.sampleRateShading; }
  bool has_ray_query() const { return acceleration.accelerationStructure && ray_query.rayQuery; }
  bool has_ray_tracing_pipeline() const {
    return acceleration.accelerationStructure && ray_pipeline.rayTracingPipeline &&
           ray_pipeline.rayTracingPipelineTraceRaysIndirect;
  }

  // Keeps of the queried features only what is used, for vkCreateDevice, and names the extensions to enable.
  VkPhysicalDeviceFeatures2* enable_chain(std::vector<const char*>& extensions);
};

}  // namespace fire3dv::gpu
