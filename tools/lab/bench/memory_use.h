// Memory use of this process on the GPU and in host memory.
#pragma once

#include <cstdint>
#include <optional>

#include "renderer/gpu/device/device.h"

namespace fire3dv::bench {

struct MemoryUse {
  uint64_t gpu_allocated_bytes = 0;             // allocated by the renderer
  std::optional<uint64_t> gpu_used_bytes;       // usage of this process as reported by the driver
                                                // (VK_EXT_memory_budget)
  std::optional<uint64_t> resident_bytes;       // resident set size
  std::optional<uint64_t> most_resident_bytes;  // peak resident set size
};

MemoryUse memory_use(const gpu::Device& device);

}  // namespace fire3dv::bench
