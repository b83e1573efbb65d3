// Selection of physical devices, with reasons for the user. It works on plain reports, so that tests need no
// GPU.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "renderer/gpu/device/device_report.h"
#include "renderer/gpu/selection/cuda_devices.h"

namespace fire3dv::gpu {

struct DeviceChoice {
  uint32_t index = 0;
  // Messages for the user: a software device was selected, and the reason against each better device.
  std::vector<std::string> notes;
};

// PCI vendor ids of GPUs from known vendors, with or without a Vulkan driver. Reads /sys; tests pass another
// root.
std::vector<uint32_t> graphics_vendors_present(
    const std::filesystem::path& pci_devices = "/sys/bus/pci/devices");

// Facts of the machine that Vulkan does not report.
struct HostFacts {
  std::vector<uint32_t> vendors_present;            // see graphics_vendors_present()
  std::optional<std::string> cuda_visible_devices;  // CUDA_VISIBLE_DEVICES
  // Called only where a request or CUDA_VISIBLE_DEVICES needs CUDA's numbers; null: there is no CUDA.
  std::function<CudaDevices()> cuda_devices;
};
HostFacts host_facts();

// Selects one device. wanted: empty, an index, part of a name (case-insensitive), cuda:N, uuid:HEX or
// pci:DDDD:BB:DD.F. Empty selects the best usable device: discrete, integrated, virtual, software; among
// NVIDIA GPUs the first one that CUDA_VISIBLE_DEVICES names. An unmatched request is an error that lists all
// devices; there is no fallback.
Result<DeviceChoice> choose_device(const std::vector<DeviceReport>& reports, std::string_view wanted,
                                   const HostFacts& host = {});

// Selects several devices: requests separated by commas, in that order, or "all" for all devices of the best
// type, of NVIDIA's those that CUDA_VISIBLE_DEVICES names. A device that is named twice is returned twice.
Result<std::vector<DeviceChoice>> choose_devices(const std::vector<DeviceReport>& reports,
                                                 std::string_view wanted, const HostFacts& host = {});

}  // namespace fire3dv::gpu
