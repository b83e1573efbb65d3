#include "tools/lab/bench/bench_device.h"

#include <cstdio>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "renderer/gpu/selection/device_choice.h"

namespace fire3dv::bench {
namespace {

bool has_memory_budget(VkPhysicalDevice device) {
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

Result<OpenDevice> open_device(const DrawOptions& options) {
  gpu::InstanceOptions instance_options;
  instance_options.validation = options.validation;
  Result<std::unique_ptr<gpu::Instance>> instance = gpu::Instance::create(instance_options);
  if (!instance) return instance.error();
  OpenDevice open;
  open.instance = std::move(*instance);
  const std::vector<gpu::DeviceReport> reports = gpu::report_devices(open.instance->handle());
  const Result<gpu::DeviceChoice> choice = gpu::choose_device(reports, options.device, gpu::host_facts());
  if (!choice) return choice.error();
  for (const std::string& note : choice->notes)
    std::fprintf(stderr, "fire3dv-bench: device: %s\n", note.c_str());
  std::fprintf(stderr, "fire3dv-bench: device %s\n", gpu::describe(reports[choice->index]).c_str());
  Result<std::unique_ptr<gpu::Device>> device =
      gpu::Device::create(*open.instance, choice->index, false, async_compute(options));
  if (!device) return device.error();
  open.device = std::move(*device);
  return open;
}

Result<void> OpenDevice::finish() {
  device.reset();
  if (const uint64_t messages = instance->validation_messages())
    return Error{std::to_string(messages) + " validation messages"};
  return {};
}

MemoryUse memory_use(const gpu::Device& device) {
  MemoryUse use;
  use.gpu_allocated_bytes = device.allocated_bytes();
  if (has_memory_budget(device.physical())) {
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
  use.peak_resident_bytes = status_bytes("VmHWM");
  return use;
}

}  // namespace fire3dv::bench
