// Staging ring for data that the CPU writes for one frame. Allocation is a pointer bump; the memory is reused
// with the frame's slot. It is write-combined: write it once, in order, and never read it.
#pragma once

#include <cstring>
#include <span>
#include <vector>

#include "renderer/gpu/resources.h"

namespace fire3dv::gpu {

class StagingRing {
 public:
  explicit StagingRing(Device& device) : device_(device) {}

  struct Piece {
    std::byte* mapped = nullptr;
    VkBuffer buffer = VK_NULL_HANDLE;
    VkDeviceSize offset = 0;
    VkDeviceAddress address = 0;
  };
  Piece allocate(VkDeviceSize size_bytes);

  template <typename T>
  Piece write(std::span<const T> values) {
    const Piece piece = allocate(values.size_bytes());
    if (!values.empty()) std::memcpy(piece.mapped, values.data(), values.size_bytes());
    return piece;
  }

  void reset();  // requires that the GPU has finished the frame

 private:
  Device& device_;
  std::vector<Buffer> chunks_;  // normally one; a frame that needs more adds chunks, and reset() keeps the
                                // largest
  VkDeviceSize used_ = 0;       // of the last chunk
};

}  // namespace fire3dv::gpu
