// Entry to Vulkan: its headers, error checks and the instance.
#pragma once

#include <vulkan/vulkan.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <vector>

#include "base/error.h"

namespace fire3dv::gpu {

// Thrown by a call that fails for an external reason (no memory, device lost). The app catches it at the top,
// or earlier where only an optional part runs out of memory. Validation in every test catches misuse.
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

#define FIRE3DV_VK(call) ::fire3dv::gpu::check((call), #call)

struct InstanceOptions {
  bool validation = false;                     // core and synchronisation validation
  std::vector<const char*> window_extensions;  // from GLFW; empty when headless
};

// Vulkan instance with optional validation. Validation messages are printed and counted.
class Instance {
 public:
  static Result<std::unique_ptr<Instance>> create(const InstanceOptions& options);
  ~Instance();
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  VkInstance handle() const { return handle_; }
  bool validation() const { return messenger_ != VK_NULL_HANDLE; }
  // Count of messages of warning severity or worse, without the listed exceptions. Each one was printed.
  uint64_t validation_messages() const { return validation_messages_; }

 private:
  Instance() = default;
  static VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                   VkDebugUtilsMessageTypeFlagsEXT types,
                                                   const VkDebugUtilsMessengerCallbackDataEXT* data,
                                                   void* user);

  VkInstance handle_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  std::atomic<uint64_t> validation_messages_ = 0;
};

}  // namespace fire3dv::gpu
