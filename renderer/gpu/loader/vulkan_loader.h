// The Vulkan loader, libvulkan.so.1, which programs load at their first use of Vulkan: without it they still
// run, and say what is missing. This room defines Vulkan's functions for the rest of the program.
#pragma once

#include <string>

namespace fire3dv::gpu {

struct VulkanLoader {
  std::string fault;  // why no Vulkan function may be called; empty: all may
  std::string file;   // path of the library
};
// Loads the library at the first call. Vulkan's functions may be called afterwards: Instance::create() does
// it.
const VulkanLoader& vulkan_loader();

}  // namespace fire3dv::gpu
