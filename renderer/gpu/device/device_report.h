// Report of a physical device: its identity, and the features that decide what it can draw.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "renderer/gpu/device/vk.h"

namespace fire3dv::gpu {

enum class DeviceType { discrete, integrated, virtual_gpu, software, other };

struct DeviceReport {
  uint32_t index = 0;  // index in the listing and of --device INDEX
  std::string name;
  std::string driver;  // name and version
  DeviceType type = DeviceType::other;
  uint32_t api_version = 0;
  uint32_t vendor_id = 0;   // PCI
  std::string uuid;         // VkPhysicalDeviceIDProperties::deviceUUID as 8-4-4-4-12 hexadecimal digits
  std::string pci_address;  // DDDD:BB:DD.F; empty: no PCI device, or a driver that does not say
  std::vector<std::string> missing;  // missing required features; empty: usable
  // optional features
  bool ray_query = false;
  bool ray_tracing_pipeline = false;
  bool int64_atomics = false;
  bool async_compute = false;
  bool anisotropy = false;  // samplers filter anisotropically
  bool dual_source_blend = false;
  bool multisample_storage = false;  // shaders can write multisampled images
  bool visible_coverage = false;     // a fragment shader can read the coverage after the depth test
  bool sorted_fragments = false;     // blended fragments can be sorted by depth in a buffer
  uint32_t max_samples = 1;

  bool usable() const { return missing.empty(); }
};

DeviceReport report_device(VkPhysicalDevice device, uint32_t index);
std::vector<DeviceReport> report_devices(VkInstance instance);

const char* type_name(DeviceType type);

// One line: index, name, type, driver and missing features.
std::string describe(const DeviceReport& report);
// UUID and PCI address, as --device takes them: "uuid:... pci:...".
std::string describe_identity(const DeviceReport& report);
// The form of DeviceReport::uuid.
std::string uuid_text(std::span<const uint8_t, VK_UUID_SIZE> uuid);

}  // namespace fire3dv::gpu
