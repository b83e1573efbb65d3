// Readback ring: asynchronous copies of images to the CPU. Each request has a tag; pixels arrive frames later
// with this tag, in order and without a stall.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <span>
#include <utility>
#include <vector>

#include "renderer/gpu/device/device.h"
#include "renderer/gpu/recorder.h"

namespace fire3dv::gpu {

template <typename Tag>
class ReadbackRing {
 public:
  explicit ReadbackRing(Device& device) : device_(device) {}

  // Planes of the same frame that are copied, too; a null buffer: none.
  struct Planes {
    Buffer* buffer = nullptr;
    VkDeviceSize bytes = 0;
  };

  // Records the copy of an image with 4 bytes a pixel. Call submitted() with the frame's timeline value.
  void record(Recorder& recorder, Image& image, Tag tag) {
    record(recorder, &image, image.extent, {}, std::move(tag));
  }
  // The same with planes, which follow the image's pixels. A null image copies planes only.
  void record(Recorder& recorder, Image* image, VkExtent2D extent, const Planes& planes, Tag tag) {
    const VkDeviceSize image_bytes = image ? VkDeviceSize{4} * extent.width * extent.height : 0;
    Pending pending{take_buffer(image_bytes + planes.bytes), extent, image_bytes + planes.bytes,
                    std::move(tag), 0};
    std::vector<Use> uses{Use(pending.buffer, access::transfer_write)};
    if (image) uses.emplace_back(*image, access::transfer_read);
    if (planes.bytes) uses.emplace_back(*planes.buffer, access::transfer_read);
    recorder.pass("read-back", uses, [&](VkCommandBuffer commands) {
      if (image) {
        VkBufferImageCopy copy{};
        copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        copy.imageExtent = {extent.width, extent.height, 1};
        vkCmdCopyImageToBuffer(commands, image->get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                               pending.buffer.get(), 1, &copy);
      }
      if (planes.bytes) {
        const VkBufferCopy copy{0, image_bytes, planes.bytes};
        vkCmdCopyBuffer(commands, planes.buffer->get(), pending.buffer.get(), 1, &copy);
      }
    });
    recorder.transition({Use(pending.buffer, access::host_read)});
    recorded_.push_back(std::move(pending));
  }

  // Allocates the buffer of a following record() of this many bytes.
  void make_room(VkDeviceSize bytes) { free_.push_back(take_buffer(bytes)); }

  void submitted(uint64_t timeline_value) {
    for (Pending& pending : recorded_) {
      pending.done_at = timeline_value;
      pending_.push_back(std::move(pending));
    }
    recorded_.clear();
  }

  // Hands over all finished images, oldest first: pixels, then planes.
  template <typename TakeImage>
  void poll(TakeImage&& take) {
    const uint64_t done = device_.completed();
    while (!pending_.empty() && pending_.front().done_at <= done) {
      Pending pending = std::move(pending_.front());
      pending_.pop_front();
      polled_ = pending.done_at;
      take(std::move(pending.tag), pending.extent,
           std::span<const uint8_t>(reinterpret_cast<const uint8_t*>(pending.buffer.mapped), pending.bytes));
      free_.push_back(std::move(pending.buffer));
    }
  }

  // The same after a wait for all submitted copies: for the end of a run, or lockstep.
  template <typename TakeImage>
  void drain(TakeImage&& take) {
    if (!pending_.empty()) device_.wait(pending_.back().done_at);
    poll(std::forward<TakeImage>(take));
  }

  // Within poll(): timeline value of the image's submission.
  uint64_t polled_submission() const { return polled_; }

  size_t in_flight() const { return pending_.size(); }

 private:
  struct Pending {
    Buffer buffer;
    VkExtent2D extent;
    VkDeviceSize bytes;
    Tag tag;
    uint64_t done_at;
  };

  Buffer take_buffer(VkDeviceSize bytes) {
    while (!free_.empty()) {
      Buffer buffer = std::move(free_.back());
      free_.pop_back();
      if (buffer.size_bytes == std::max<VkDeviceSize>(bytes, 64)) {
        buffer.use = {};  // the ring was its last user, and that use is over
        return buffer;
      }
    }
    return create_buffer(device_, bytes, 0, Memory::readback);
  }

  Device& device_;
  std::vector<Pending> recorded_;
  std::deque<Pending> pending_;
  std::vector<Buffer> free_;
  uint64_t polled_ = 0;
};

}  // namespace fire3dv::gpu
