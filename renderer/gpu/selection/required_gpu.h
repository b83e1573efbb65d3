// --require-gpu: a run fails rather than draw on the CPU.
#pragma once

#include <string_view>
#include <vector>

#include "base/error.h"
#include "renderer/gpu/selection/device_choice.h"

namespace fire3dv::gpu {

constexpr int kNoGpuExitStatus = 3;  // of every program, where check_required_gpu() fails

// An error where a device that the options choose is a software device, or no GPU can draw. A request that
// fits no device is no error here: opening the device reports it. device, devices: values of --device and
// --devices.
Result<void> check_required_gpu(const std::vector<DeviceReport>& reports, std::string_view device,
                                std::string_view devices, const HostFacts& host);
// Of this machine, by an instance of its own: call it first, before a scene is loaded.
Result<void> check_required_gpu(std::string_view device, std::string_view devices = {});

}  // namespace fire3dv::gpu
