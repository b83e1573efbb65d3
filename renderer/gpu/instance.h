// The Vulkan instance, with validation when asked for.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "renderer/gpu/vk.h"

namespace fire3dv::gpu {

struct InstanceOptions {
  bool validation = false;                     // core and synchronisation validation
  std::vector<const char*> window_extensions;  // as GLFW names them; empty when headless
};

class Instance {
 public:
  static Result<std::unique_ptr<Instance>> create(const InstanceOptions& options);
  ~Instance();
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  VkInstance handle() const { return handle_; }
  bool validation() const { return messenger_ != VK_NULL_HANDLE; }
  // Messages of warning severity or worse so far, without the listed exceptions. Each was printed.
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
