// Work on the GPU outside frames: uploads while a scene is loaded, acceleration structures of its meshes,
// what is prepared once and kept. finish() waits for its own submissions; frames never use this.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "renderer/gpu/device.h"
#include "renderer/gpu/recorder.h"

namespace fire3dv::gpu {

class LoaderCommands {
 public:
  explicit LoaderCommands(Device& device);
  ~LoaderCommands();

  // Buffers that are mapped are written in place, so they must be new: no work that uses them may be under
  // way. Others are copied to through staging memory; when that is full, this submits by itself.
  void upload(Buffer& buffer, VkDeviceSize offset, std::span<const std::byte> bytes);
  template <typename T>
  void upload(Buffer& buffer, std::span<const T> values) {
    upload(buffer, 0, std::as_bytes(values));
  }
  // Takes what `fill` writes, piece by piece: [offset, offset + to.size()) of the buffer. Pieces begin and
  // end at multiples of unit.
  void upload(Buffer& buffer, VkDeviceSize size, VkDeviceSize unit,
              const std::function<void(VkDeviceSize offset, std::span<std::byte> to)>& fill);
  // Fills a new image, all its levels, each with all layers, texels of a multiple of 4 bytes, rows tightly
  // packed. Leaves it ready for sampling.
  void upload_levels(Image& image, std::span<const std::span<const std::byte>> levels);

  // Fills one level, its rows tightly packed; whoever fills the last one makes the image ready for its use.
  void upload_level(Image& image, uint32_t level, std::span<const std::byte> bytes);

  // One level's texels, all its layers, rows tightly packed, to a buffer; whoever asks for the last one makes
  // the buffer ready for its use.
  void download_level(Image& image, uint32_t level, Buffer& to, VkDeviceSize offset);

  Recorder& recorder();
  void submit();  // without waiting; whatever is recorded next waits first
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
  uint64_t submitted_ = 0;  // what has not been waited for; 0: none
};

}  // namespace fire3dv::gpu
