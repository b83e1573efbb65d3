// Entry header for Vulkan: the Vulkan headers, error checks and VulkanFailure. A call that fails for an
// external reason (no memory, device lost) throws. The app catches the exception at the top, or earlier where
// only an optional part runs out of memory. Validation in every test catches misuse.
#pragma once

#include <vulkan/vulkan.h>

#include <stdexcept>
#include <string>

namespace fire3dv::gpu {

class VulkanFailure : public std::runtime_error {
 public:
  VulkanFailure(VkResult result, const char* call);
  VkResult result;
};

const char* result_name(VkResult result);

inline bool is_out_of_memory(const VulkanFailure& failure) {
  return failure.result == VK_ERROR_OUT_OF_DEVICE_MEMORY || failure.result == VK_ERROR_OUT_OF_HOST_MEMORY;
}

inline void check(VkResult result, const char* call) {
  if (result < 0) throw VulkanFailure(result, call);
}

}  // namespace fire3dv::gpu

#define FIRE3DV_VK(call) ::fire3dv::gpu::check((call), #call)
