#include "tools/lab/bench/memory_use.h"

#include <cstring>
#include <fstream>
#include <string>
#include <vector>

namespace fire3dv::bench {
namespace {

bool tells_its_budget(VkPhysicalDevice device) {
  uint32_t count = 0;
  FIRE3DV_VK(vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr));
  std::vector<VkExtensionProperties> extensions(count);
  FIRE3DV_VK(vkEnumerateDeviceExtensionProperties(device, nullptr, &count, extensions.data()));
  for (const VkExtensionProperties& extension : extensions) {
    if (std::strcmp(extension.extensionName, VK_EXT_MEMORY_BUDGET_EXTENSION_NAME) == 0) return true;
  }
  return false;
}

// Reads a field of /proc/self/status, which is in kB.
std::optional<uint64_t> status_bytes(const std::string& field) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.compare(0, field.size(), field) != 0) continue;
    return std::strtoull(line.c_str() + field.size() + 1, nullptr, 10) * 1024;
  }
  return std::nullopt;
}

}  // namespace

MemoryUse memory_use(const gpu::Device& device) {
  MemoryUse use;
  use.gpu_allocated_bytes = device.allocated_bytes();
  if (tells_its_budget(device.physical())) {
    // The extension's structure belongs to the physical device and needs no enabling on the logical one.
    VkPhysicalDeviceMemoryBudgetPropertiesEXT budget{
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_BUDGET_PROPERTIES_EXT};
    VkPhysicalDeviceMemoryProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_PROPERTIES_2};
    properties.pNext = &budget;
    vkGetPhysicalDeviceMemoryProperties2(device.physical(), &properties);
    uint64_t used = 0;
    for (uint32_t heap = 0; heap < properties.memoryProperties.memoryHeapCount; ++heap) {
      if (properties.memoryProperties.memoryHeaps[heap].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
        used += budget.heapUsage[heap];
    }
    use.gpu_used_bytes = used;
  }
  use.resident_bytes = status_bytes("VmRSS");
  use.most_resident_bytes = status_bytes("VmHWM");
  return use;
}

}  // namespace fire3dv::bench
