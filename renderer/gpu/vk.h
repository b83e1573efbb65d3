// The one door to Vulkan. A Vulkan call that fails for a reason outside this program (no memory, device lost)
// throws VulkanFailure. The app catches it at the top, and before where memory fails that only a part needs.
// Misuse of Vulkan is caught by validation in every test.
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
