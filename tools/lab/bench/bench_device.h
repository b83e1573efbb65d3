// Vulkan device of a benchmark: opening, and memory in use.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "renderer/gpu/device/device.h"
#include "tools/lab/bench/frames/frame_commands.h"

namespace fire3dv::bench {

struct OpenDevice {
  std::unique_ptr<gpu::Instance> instance;
  std::unique_ptr<gpu::Device> device;

  // Returns an error when validation was on and has reported a problem.
  Result<void> finish();
};

Result<OpenDevice> open_device(const DrawOptions& options);

struct MemoryUse {
  uint64_t gpu_allocated_bytes = 0;             // allocated by the renderer
  std::optional<uint64_t> gpu_used_bytes;       // usage of this process as reported by the driver
                                                // (VK_EXT_memory_budget)
  std::optional<uint64_t> resident_bytes;       // resident set size
  std::optional<uint64_t> peak_resident_bytes;  // peak resident set size
};

MemoryUse memory_use(const gpu::Device& device);

}  // namespace fire3dv::bench
