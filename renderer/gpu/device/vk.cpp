#include "renderer/gpu/device/vk.h"

namespace fire3dv::gpu {

const char* result_name(VkResult result) {
  switch (result) {
    case VK_SUCCESS:
      return "success";
    case VK_ERROR_OUT_OF_HOST_MEMORY:
      return "out of host memory";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
      return "out of device memory";
    case VK_ERROR_INITIALIZATION_FAILED:
      return "initialisation failed";
    case VK_ERROR_DEVICE_LOST:
      return "device lost";
    case VK_ERROR_LAYER_NOT_PRESENT:
      return "layer not present";
    case VK_ERROR_EXTENSION_NOT_PRESENT:
      return "extension not present";
    case VK_ERROR_FEATURE_NOT_PRESENT:
      return "feature not present";
    case VK_ERROR_INCOMPATIBLE_DRIVER:
      return "incompatible driver";
    case VK_ERROR_SURFACE_LOST_KHR:
      return "surface lost";
    case VK_ERROR_OUT_OF_DATE_KHR:
      return "swapchain out of date";
    default:
      return "error";
  }
}

// Shortens "vkCreateBuffer(device, ...)" to the function name for users.
static std::string describe(VkResult code, const char* call) {
  const std::string text = call;
  const char* const remedy = code == VK_ERROR_DEVICE_LOST
                                 ? "; the GPU was reset or is gone: start it again, and "
                                   "look into the system's log where that comes back"
                                 : "";
  return text.substr(0, text.find('(')) + ": " + result_name(code) + " (" + std::to_string(code) + ")" +
         remedy;
}

VulkanFailure::VulkanFailure(VkResult code, const char* call)
    : std::runtime_error(describe(code, call)), result(code) {}

}  // namespace fire3dv::gpu
