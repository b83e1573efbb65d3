// Which device to draw on, and why. The choice works on plain reports, so that it is tested without a GPU.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/error.h"
#include "renderer/gpu/vk.h"

namespace fire3dv::gpu {

enum class DeviceType { discrete, integrated, virtual_gpu, software, other };

struct DeviceReport {
  uint32_t index = 0;  // as listed; what --device INDEX means
  std::string name;
  std::string driver;  // name and version
  DeviceType type = DeviceType::other;
  uint32_t api_version = 0;
  uint32_t vendor_id = 0;            // PCI
  std::vector<std::string> missing;  // required features it lacks; empty = usable
  // optional features
  bool ray_query = false;
  bool ray_tracing_pipeline = false;
  bool int64_atomics = false;
  bool async_compute = false;
  bool anisotropy = false;
  bool dual_source_blend = false;
  bool multisample_storage = false;  // shaders can write multisampled images
  bool visible_coverage = false;     // a fragment shader can know which samples the depth test has left
  uint32_t max_samples = 1;

  bool usable() const { return missing.empty(); }
};

DeviceReport report_device(VkPhysicalDevice device, uint32_t index);
std::vector<DeviceReport> report_devices(VkInstance instance);

const char* type_name(DeviceType type);

// One line for --list-devices: index, name, type, driver, what it lacks.
std::string describe(const DeviceReport& report);

struct DeviceChoice {
  uint32_t index = 0;
  // Sentences for the user: a software device was taken, and why each better one was not.
  std::vector<std::string> notes;
};

// Graphics processors of known makers on the PCI bus, whether a Vulkan driver serves them or not: their
// vendor ids. Reads /sys; tests name another root.
std::vector<uint32_t> graphics_vendors_present(
    const std::filesystem::path& pci_devices = "/sys/bus/pci/devices");

// wanted: empty, an index, or part of a name (any case). Without a wish the best usable device wins:
// discrete, integrated, virtual, software. A wish that cannot be met is an error that lists what there is;
// nothing is taken instead. vendors_present: as above, so that a GPU without a driver is named when a
// software device is taken.
Result<DeviceChoice> choose_device(const std::vector<DeviceReport>& reports, std::string_view wanted,
                                   const std::vector<uint32_t>& vendors_present = {});

// Several: wished as above, separated by commas, in that order, or "all" of the best type there is. One that
// is named twice is taken twice.
Result<std::vector<DeviceChoice>> choose_devices(const std::vector<DeviceReport>& reports,
                                                 std::string_view wanted,
                                                 const std::vector<uint32_t>& vendors_present = {});

}  // namespace fire3dv::gpu
