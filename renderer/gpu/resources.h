// Buffers and images: a handle, what a shader needs to reach it, and how it was last used, from which the
// recorder derives barriers.
#pragma once

#include <cstddef>
#include <cstdint>

#include "renderer/gpu/handle.h"
#include "renderer/gpu/vk.h"

namespace fire3dv::gpu {

// How commands touch a resource.
struct Access {
  VkPipelineStageFlags2 stages = 0;
  VkAccessFlags2 access = 0;
  bool writes = false;
  VkImageLayout layout = VK_IMAGE_LAYOUT_GENERAL;  // images only
};

// The accesses since, and with, the last write. Kept by the recorder.
struct UseState {
  VkPipelineStageFlags2 write_stages = 0;
  VkAccessFlags2 write_access = 0;
  VkPipelineStageFlags2 read_stages = 0;     // since that write
  VkPipelineStageFlags2 visible_stages = 0;  // which stages and accesses the write was made visible to
  VkAccessFlags2 visible_access = 0;
  VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
  // The forks of frames in which the side queue last wrote and read it; 0: none that still matters.
  uint64_t side_write = 0, side_read = 0;
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
  VkFormat written_as = VK_FORMAT_UNDEFINED;  // what shaders write; `format`, unless ImageInfo says another
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
  shared,    // `device`, and mapped: for software devices, all of whose memory is the CPU's
};

// Of what is filled once, by LoaderCommands: `device`, or `shared` where it can be.
Memory filled_memory(const Device& device);

// usage is extended by SHADER_DEVICE_ADDRESS and the transfer bits. A size of 0 becomes a small one, so that
// an empty scene needs no special case.
Buffer create_buffer(Device& device, VkDeviceSize size_bytes, VkBufferUsageFlags usage, Memory memory);

struct ImageInfo {
  VkFormat format = VK_FORMAT_R8G8B8A8_UNORM;
  VkExtent2D extent{};
  VkImageUsageFlags usage = 0;
  uint32_t mip_levels = 1;
  VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
  bool cube = false;  // six layers, seen as the faces of a cube
  // For a format that shaders cannot write: one of as many bits that they can. Undefined: the format itself.
  VkFormat written_as = VK_FORMAT_UNDEFINED;
};
Image create_image(Device& device, const ImageInfo& info);
// One level as an array of its layers, as it is written: what a shader can write to.
ImageView create_level_view(Device& device, const Image& image, uint32_t level);

}  // namespace fire3dv::gpu
