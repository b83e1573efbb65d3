#include "renderer/gpu/staging_ring.h"

#include <algorithm>

namespace fire3dv::gpu {
namespace {
constexpr VkDeviceSize kAlignment = 256;  // maximum alignment of all uses in shaders and copies
constexpr VkDeviceSize kFirstChunk = 256 << 10;
}  // namespace

StagingRing::Piece StagingRing::allocate(VkDeviceSize size_bytes) {
  const VkDeviceSize size = (size_bytes + kAlignment - 1) / kAlignment * kAlignment;
  if (chunks_.empty() || used_ + size > chunks_.back().size_bytes) {
    const VkDeviceSize chunk =
        std::max({kFirstChunk, size, chunks_.empty() ? 0 : chunks_.back().size_bytes * 2});
    chunks_.push_back(create_buffer(device_, chunk,
                                    VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT,
                                    Memory::upload));
    used_ = 0;
  }
  const Buffer& chunk = chunks_.back();
  const Piece piece{chunk.mapped + used_, chunk.get(), used_, chunk.address + used_};
  used_ += size;
  return piece;
}

void StagingRing::reset() {
  if (chunks_.size() > 1) chunks_.erase(chunks_.begin(), chunks_.end() - 1);  // keep the largest
  used_ = 0;
}

}  // namespace fire3dv::gpu
