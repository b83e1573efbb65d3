// Buffers and images: the handle, the address or view for shaders, and the use state. The recorder derives
// barriers from the use state.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <thread>
#include <vector>

#include "renderer/gpu/device/handle.h"
#include "renderer/gpu/device/vk.h"

namespace fire3dv::gpu {

// One kind of access by commands to a resource.
struct Access {
  VkPipelineStageFlags2 stages = 0;
  VkAccessFlags2 access = 0;
  bool writes = false;
  VkImageLayout layout = VK_IMAGE_LAYOUT_GENERAL;  // images only
};

// Accesses since the last write, including it. The recorder updates it.
struct UseState {
  VkPipelineStageFlags2 write_stages = 0;
  VkAccessFlags2 write_access = 0;
  VkPipelineStageFlags2 read_stages = 0;     // since that write
  VkPipelineStageFlags2 visible_stages = 0;  // stages and accesses that see the write
  VkAccessFlags2 visible_access = 0;
  VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
  // Fork numbers of the async queue's last write and read; 0: no pending access.
  uint64_t async_write = 0, async_read = 0;
};

struct Buffer {
  BufferHandle handle;
  VkDeviceSize size_bytes = 0;
  VkDeviceAddress address = 0;
  std::byte* mapped = nullptr;  // host-visible buffers only, coherent
  UseState use;

  VkBuffer get() const { return handle.get(); }
  explicit operator bool() const { return static_cast<bool>(handle); }
};

struct Image {
  ImageHandle handle;
  ImageView view;  // the whole image
  VkFormat format = VK_FORMAT_UNDEFINED;
  VkFormat written_as = VK_FORMAT_UNDEFINED;  // format of shader writes; differs from `format` only where
                                              // ImageInfo requests it
  VkExtent2D extent{};
  uint32_t mip_levels = 1;
  uint32_t layers = 1;
  VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
  VkImageAspectFlags aspect = VK_IMAGE_ASPECT_COLOR_BIT;
  UseState use;

  VkImage get() const { return handle.get(); }
  explicit operator bool() const { return static_cast<bool>(handle); }
};

enum class Memory {
  device,    // fastest for the GPU
  upload,    // written by the CPU in order, read by the GPU; mapped
  readback,  // written by the GPU, read by the CPU; mapped, cached
  shared,    // `device`, and mapped: for software devices, whose memory is the CPU's
};

// Memory type of buffers that LoaderCommands fills once: `shared` where possible, otherwise `device`.
Memory filled_memory(const Device& device);

// Adds SHADER_DEVICE_ADDRESS and the transfer bits to usage. A size of 0 becomes a small one, so that an
// empty scene needs no special case.
Buffer create_buffer(Device& device, VkDeviceSize size_bytes, VkBufferUsageFlags usage, Memory memory);

// Replaces a storage buffer in device memory that is too small, without its contents. Returns true if it did.
inline bool grow_storage_buffer(Device& device, Buffer& buffer, VkDeviceSize size_bytes,
                                VkBufferUsageFlags more_usage = 0) {
  if (buffer && buffer.size_bytes >= size_bytes) return false;
  buffer = create_buffer(device, size_bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | more_usage, Memory::device);
  return true;
}

struct ImageInfo {
  VkFormat format = VK_FORMAT_R8G8B8A8_UNORM;
  VkExtent2D extent{};
  VkImageUsageFlags usage = 0;
  uint32_t mip_levels = 1;
  VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
  bool cube = false;  // six layers, viewed as the faces of a cube
  // Storage format of the same size, for a format that shaders cannot write. Undefined: the format itself.
  VkFormat written_as = VK_FORMAT_UNDEFINED;
};
Image create_image(Device& device, const ImageInfo& info);
// View of one level as an array of its layers, in the format of shader writes.
ImageView create_level_view(Device& device, const Image& image, uint32_t level);

// Pre-faults memory that a software device is about to write: a background thread populates the pages of each
// piece in order. Other threads may write them meanwhile, and their content stays. Reason: an operating
// system needs about as long for a first-touch page fault as such a device for the write itself. The thread
// ends early on a stop request, as its destructor sends one; the memory must outlive it. Without system
// support or a free thread the call has no effect.
std::jthread prefault(std::vector<std::span<std::byte>> pieces);

}  // namespace fire3dv::gpu
