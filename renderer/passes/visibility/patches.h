// Partial buffer updates between frames. Passes do not declare these rarely written buffers, so frames with
// patches have one full barrier.
#pragma once

#include <cstring>
#include <span>
#include <vector>

#include "renderer/gpu/recorder.h"
#include "renderer/gpu/staging_ring.h"

namespace fire3dv::passes {

class Patches {
 public:
  template <typename T>
  void write(const gpu::Buffer& to, VkDeviceSize offset, std::span<const T> values) {
    if (values.empty()) return;
    const size_t at = bytes_.size();
    bytes_.resize(at + values.size_bytes());
    std::memcpy(bytes_.data() + at, values.data(), values.size_bytes());
    uploads_.push_back({VK_NULL_HANDLE, to.get(), {at, offset, values.size_bytes()}});
  }
  template <typename T>
  void write(const gpu::Buffer& to, VkDeviceSize offset, const T& value) {
    write(to, offset, std::span<const T>(&value, 1));
  }
  // Copies within one buffer. Source ranges must not overlap other patches.
  void copy(const gpu::Buffer& buffer, VkDeviceSize from, VkDeviceSize to, VkDeviceSize bytes) {
    uploads_.push_back({buffer.get(), buffer.get(), {from, to, bytes}});
  }
  // Grows the buffer to at least this size; its first used_bytes are preserved.
  void reserve(gpu::Device& device, gpu::Buffer& buffer, VkDeviceSize used_bytes, VkDeviceSize bytes);

  bool empty() const { return uploads_.empty() && moves_.empty(); }
  void record(gpu::Recorder& recorder, gpu::StagingRing& staging);

 private:
  struct Copy {
    VkBuffer from;  // null: source is bytes_
    VkBuffer to;
    VkBufferCopy region;
  };
  std::vector<std::byte> bytes_;
  std::vector<Copy> uploads_, moves_;
};

}  // namespace fire3dv::passes
