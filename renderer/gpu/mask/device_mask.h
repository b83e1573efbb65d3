// Mask of a device's features and limits, for tests and diagnosis: the device looks like a smaller one. Its
// words are in the environment variable FIRE3DV_DEVICE_MASK, separated by commas; CONTRIBUTING.md lists them.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace fire3dv::gpu {

struct DeviceMask {
  std::string text;  // the variable's value
  bool no_ray_query = false, no_ray_pipeline = false;
  bool no_int64_atomics = false;
  bool no_async_queue = false;
  bool no_anisotropy = false, no_dual_source = false, no_sample_shading = false;
  bool no_multisample_storage = false, no_visible_coverage = false;
  bool no_indirect_count = false;
  bool no_scalar_layout = false, no_subgroup_operations = false;  // required: the device is refused
  bool no_software = false;  // a software device counts as a discrete GPU, and is given a GPU's shaders
  uint32_t samples = 0, subgroup = 0, threads = 0,
           image_side = 0;  // upper limits, or the size; 0: the device's

  bool hides_extension(std::string_view name) const;
  void apply(VkPhysicalDeviceFeatures& core, VkPhysicalDeviceVulkan12Features& vulkan12) const;
  void apply(VkPhysicalDeviceLimits& limits) const;
  void apply(VkPhysicalDeviceVulkan11Properties& properties) const;
  void apply(std::vector<VkQueueFamilyProperties>& families) const;
};

// An error names the unknown word and lists all words, or names the number that no device has.
Result<DeviceMask> parse_device_mask(std::string_view text);

// Mask of the environment, read once. An invalid one masks nothing: Instance::create() reports it.
const Result<DeviceMask>& environment_mask();
const DeviceMask& device_mask();

}  // namespace fire3dv::gpu
