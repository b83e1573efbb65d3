// Vulkan instance with optional validation. Validation messages are printed and counted.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "renderer/gpu/device/vk.h"

namespace fire3dv::gpu {

struct InstanceOptions {
  bool validation = false;                     // core and synchronisation validation
  std::vector<const char*> window_extensions;  // from GLFW; empty when headless
};

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
