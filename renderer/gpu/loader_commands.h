// Command buffer for GPU work outside frames: scene uploads, acceleration structures of meshes and cached
// artefacts. finish() waits for its own submissions; frames never use this class.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "renderer/gpu/device/device.h"
#include "renderer/gpu/recorder.h"

namespace fire3dv::gpu {

class LoaderCommands {
 public:
  explicit LoaderCommands(Device& device);
  ~LoaderCommands();

  // Writes mapped buffers in place, so no pending work may use them. Copies to other buffers through staging
  // memory; when that is full, the call submits.
  void upload(Buffer& buffer, VkDeviceSize offset, std::span<const std::byte> bytes);
  template <typename T>
  void upload(Buffer& buffer, std::span<const T> values) {
    upload(buffer, 0, std::as_bytes(values));
  }
  // Uploads data that `fill` writes piece by piece: [offset, offset + to.size()) of the buffer. Pieces begin
  // and end at multiples of unit.
  void upload(Buffer& buffer, VkDeviceSize size, VkDeviceSize unit,
              const std::function<void(VkDeviceSize offset, std::span<std::byte> to)>& fill);
  // Fills all levels of a new image, each with all layers. Texels have a multiple of 4 bytes, rows are
  // tightly packed. Leaves the image ready for sampling.
  void upload_levels(Image& image, std::span<const std::span<const std::byte>> levels);

  // Fills one level; rows are tightly packed. After the last level the caller transitions the image for its
  // use.
  void upload_level(Image& image, uint32_t level, std::span<const std::byte> bytes);

  // Copies one level's texels, all layers, rows tightly packed, to a buffer. After the last level the caller
  // transitions the buffer for its use.
  void download_level(Image& image, uint32_t level, Buffer& to, VkDeviceSize offset);

  Recorder& recorder();
  void submit();  // does not wait; the next recording waits first
  void finish();  // submits and waits

 private:
  void upload_piece(Buffer& buffer, VkDeviceSize offset, VkDeviceSize size,
                    const std::function<void(std::span<std::byte>)>& fill);
  std::byte* stage(VkDeviceSize bytes, VkDeviceSize& offset);

  Device& device_;
  CommandPool pool_;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  Buffer staging_;
  VkDeviceSize staged_ = 0;
  std::optional<Recorder> recorder_;
  uint64_t submitted_ = 0;  // timeline value not waited for yet; 0: none
};

// New buffer with these values.
template <typename T>
Buffer upload_array(Device& device, LoaderCommands& loader, const std::vector<T>& values,
                    VkBufferUsageFlags usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT) {
  Buffer buffer = create_buffer(device, values.size() * sizeof(T), usage, filled_memory(device));
  loader.upload(buffer, std::span<const T>(values));
  return buffer;
}

}  // namespace fire3dv::gpu
