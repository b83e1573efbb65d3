// Selection by CUDA's names: ordinals, and CUDA_VISIBLE_DEVICES.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "renderer/gpu/selection/device_choice.h"

namespace fire3dv::gpu {

bool has_uuid(const std::vector<DeviceReport>& reports, std::string_view uuid);

// UUID of CUDA's device `ordinal`. Errors start with what is wrong, without the option's name.
Result<std::string> uuid_of_cuda_device(uint32_t ordinal, const HostFacts& host);

// Effect of CUDA_VISIBLE_DEVICES on a choice by default.
struct CudaFilter {
  bool is_active = false;         // the variable chooses among NVIDIA's GPUs
  std::vector<uint32_t> indices;  // of reports that it names, in CUDA's order
  std::string note;               // for the user; empty: nothing to say

  // True for NVIDIA's GPUs that the variable does not name.
  bool hides(const DeviceReport& report) const;
};
// Not active where the machine has fewer than two GPUs by NVIDIA, and where the variable names none.
CudaFilter filter_by_cuda(const std::vector<DeviceReport>& reports, const HostFacts& host);

}  // namespace fire3dv::gpu
