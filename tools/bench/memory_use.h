// How much memory a process uses, on the GPU and beside it.
#pragma once

#include <cstdint>
#include <optional>

#include "renderer/gpu/device.h"

namespace fire3dv::bench {

struct MemoryUse {
  uint64_t gpu_allocated_bytes = 0;        // what the renderer has asked for
  std::optional<uint64_t> gpu_used_bytes;  // what the driver says this process uses (VK_EXT_memory_budget)
  std::optional<uint64_t> resident_bytes;  // of the process, now
  std::optional<uint64_t> most_resident_bytes;  // so far
};

MemoryUse memory_use(const gpu::Device& device);

}  // namespace fire3dv::bench
