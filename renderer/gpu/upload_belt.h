// Memory that the CPU fills for one frame. Allocation is a pointer bump; the memory is reused when the
// frame's slot comes round. Write-combined: write it once, in order, and never read it.
#pragma once

#include <cstring>
#include <span>
#include <vector>

#include "renderer/gpu/resources.h"

namespace fire3dv::gpu {

class UploadBelt {
 public:
  explicit UploadBelt(Device& device) : device_(device) {}

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

  void reset();  // the GPU has finished with the frame

 private:
  Device& device_;
  std::vector<Buffer> chunks_;  // normally one; more after a frame that needed more, then merged
  VkDeviceSize used_ = 0;       // of the last chunk
};

}  // namespace fire3dv::gpu
