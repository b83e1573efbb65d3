// Selection of physical devices, with reasons for the user. It works on plain reports, so that tests need no
// GPU.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
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

struct DeviceChoice {
  uint32_t index = 0;
  // Messages for the user: a software device was selected, and the reason against each better device.
  std::vector<std::string> notes;
};

// PCI vendor ids of GPUs from known vendors, with or without a Vulkan driver. Reads /sys; tests pass another
// root.
std::vector<uint32_t> graphics_vendors_present(
    const std::filesystem::path& pci_devices = "/sys/bus/pci/devices");

// Selects one device. wanted: empty, an index, or part of a name (case-insensitive). Empty selects the best
// usable device: discrete, integrated, virtual, software. An unmatched request is an error that lists all
// devices; there is no fallback. vendors_present: see graphics_vendors_present; names a GPU without a driver
// when a software device is selected.
Result<DeviceChoice> choose_device(const std::vector<DeviceReport>& reports, std::string_view wanted,
                                   const std::vector<uint32_t>& vendors_present = {});

// Selects several devices: requests separated by commas, in that order, or "all" for all devices of the best
// type. A device that is named twice is returned twice.
Result<std::vector<DeviceChoice>> choose_devices(const std::vector<DeviceReport>& reports,
                                                 std::string_view wanted,
                                                 const std::vector<uint32_t>& vendors_present = {});

}  // namespace fire3dv::gpu
