#include "renderer/gpu/device/resources.h"

#include <sys/mman.h>
#include <unistd.h>
#include <vk_mem_alloc.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "renderer/gpu/device/device.h"

namespace fire3dv::gpu {
namespace {

ImageView create_view(Device& device, const Image& image, VkImageViewType type, VkFormat format,
                      VkImageUsageFlags usage, const VkImageSubresourceRange& range) {
  VkImageViewUsageCreateInfo usage_info{VK_STRUCTURE_TYPE_IMAGE_VIEW_USAGE_CREATE_INFO};
  usage_info.usage = usage;
  VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO, &usage_info};
  info.image = image.get();
  info.viewType = type;
  info.format = format;
  info.subresourceRange = range;
  VkImageView view = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateImageView(device.handle(), &info, nullptr, &view));
  return ImageView(device, view);
}

constexpr size_t kStep = size_t{1} << 20;  // bytes between checks of the stop token

// Returns false when the system lacks the call or the memory.
bool touch([[maybe_unused]] uintptr_t begin, [[maybe_unused]] uintptr_t end) {
#ifdef MADV_POPULATE_WRITE
  return madvise(reinterpret_cast<void*>(begin), end - begin, MADV_POPULATE_WRITE) == 0;
#else
  return false;
#endif
}

void touch_all(const std::stop_token& stop, const std::vector<std::span<std::byte>>& pieces) {
  const auto page = static_cast<uintptr_t>(sysconf(_SC_PAGESIZE));
  for (const std::span<std::byte> piece : pieces) {
    const auto first = reinterpret_cast<uintptr_t>(piece.data());
    const uintptr_t begin = (first + page - 1) / page * page, end = (first + piece.size()) / page * page;
    for (uintptr_t at = begin; at < end; at += kStep) {
      if (stop.stop_requested() || !touch(at, std::min(at + kStep, end))) return;
    }
  }
}

}  // namespace
Memory filled_memory(const Device& device) {
  return device.report().type == DeviceType::software ? Memory::shared : Memory::device;
}

Buffer create_buffer(Device& device, VkDeviceSize size_bytes, VkBufferUsageFlags usage, Memory memory) {
  Buffer buffer;
  buffer.size_bytes = std::max<VkDeviceSize>(size_bytes, 64);

  VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  info.size = buffer.size_bytes;
  info.usage = usage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
               VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  // Both queues use the buffers of acceleration structures and their inputs, so sharing is concurrent. Images
  // could lose compression by that, buffers cannot; ownership transfers would cost two barriers a buffer and
  // frame. Scratch memory belongs to the async queue alone.
  constexpr VkBufferUsageFlags kOfBothQueues =
      VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
      VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR;
  const uint32_t families[] = {device.queues().main_family, device.queues().async_family};
  if ((usage & kOfBothQueues) && device.queues().two_families()) {
    info.sharingMode = VK_SHARING_MODE_CONCURRENT;
    info.queueFamilyIndexCount = 2;
    info.pQueueFamilyIndices = families;
  }

  VmaAllocationCreateInfo allocation_info{};
  switch (memory) {
    case Memory::device:
      allocation_info.usage = VMA_MEMORY_USAGE_AUTO_PREFER_DEVICE;
      break;
    case Memory::shared:
      allocation_info.usage = VMA_MEMORY_USAGE_AUTO_PREFER_DEVICE;
      allocation_info.flags = VMA_ALLOCATION_CREATE_HOST_ACCESS_RANDOM_BIT | VMA_ALLOCATION_CREATE_MAPPED_BIT;
      allocation_info.requiredFlags = VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
      break;
    case Memory::upload:
      allocation_info.usage = VMA_MEMORY_USAGE_AUTO;
      allocation_info.flags =
          VMA_ALLOCATION_CREATE_HOST_ACCESS_SEQUENTIAL_WRITE_BIT | VMA_ALLOCATION_CREATE_MAPPED_BIT;
      allocation_info.requiredFlags = VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
      break;
    case Memory::readback:
      allocation_info.usage = VMA_MEMORY_USAGE_AUTO;
      allocation_info.flags = VMA_ALLOCATION_CREATE_HOST_ACCESS_RANDOM_BIT | VMA_ALLOCATION_CREATE_MAPPED_BIT;
      allocation_info.requiredFlags = VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
      break;
  }

  VkBuffer handle = VK_NULL_HANDLE;
  VmaAllocation allocation = nullptr;
  VmaAllocationInfo allocated{};
  device.begin_allocation();
  FIRE3DV_VK(vmaCreateBuffer(device.allocator(), &info, &allocation_info, &handle, &allocation, &allocated));
  buffer.handle = BufferHandle(device, handle, allocation);
  buffer.mapped = memory == Memory::device ? nullptr : static_cast<std::byte*>(allocated.pMappedData);
  // A full address space: the allocation succeeds, and its mapping does not. Mesa 25.0 then hands on
  // MAP_FAILED.
  if (memory != Memory::device && (!buffer.mapped || buffer.mapped == MAP_FAILED))
    throw VulkanFailure(VK_ERROR_OUT_OF_HOST_MEMORY, "vmaCreateBuffer, mapping");

  VkBufferDeviceAddressInfo address{VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO};
  address.buffer = handle;
  buffer.address = vkGetBufferDeviceAddress(device.handle(), &address);
  return buffer;
}

namespace {

Image create_layers(Device& device, const ImageInfo& info, uint32_t layers, VkImageViewType view_type) {
  Image image;
  image.format = info.format;
  image.written_as = info.written_as == VK_FORMAT_UNDEFINED ? info.format : info.written_as;
  image.extent = info.extent;
  image.mip_levels = info.mip_levels;
  image.layers = layers;
  image.samples = info.samples;
  image.aspect = info.format == VK_FORMAT_D32_SFLOAT ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;

  VkImageCreateInfo create{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
  const bool written_as_another = image.written_as != image.format;
  if (info.cube) create.flags |= VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT;
  if (written_as_another)
    create.flags |= VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT | VK_IMAGE_CREATE_EXTENDED_USAGE_BIT;
  create.imageType = VK_IMAGE_TYPE_2D;
  create.format = info.format;
  create.extent = {info.extent.width, info.extent.height, 1};
  create.mipLevels = info.mip_levels;
  create.arrayLayers = image.layers;
  create.samples = info.samples;
  create.usage = info.usage;

  VmaAllocationCreateInfo allocation_info{};
  allocation_info.usage = VMA_MEMORY_USAGE_AUTO_PREFER_DEVICE;
  VkImage handle = VK_NULL_HANDLE;
  VmaAllocation allocation = nullptr;
  device.begin_allocation();
  FIRE3DV_VK(vmaCreateImage(device.allocator(), &create, &allocation_info, &handle, &allocation, nullptr));
  image.handle = ImageHandle(device, handle, allocation);

  const VkImageUsageFlags usage =
      written_as_another ? info.usage & ~VkImageUsageFlags{VK_IMAGE_USAGE_STORAGE_BIT} : info.usage;
  image.view = create_view(device, image, view_type, image.format, usage,
                           {image.aspect, 0, info.mip_levels, 0, image.layers});
  return image;
}

}  // namespace

Image create_image(Device& device, const ImageInfo& info) {
  return create_layers(device, info, info.cube ? 6 : 1,
                       info.cube ? VK_IMAGE_VIEW_TYPE_CUBE : VK_IMAGE_VIEW_TYPE_2D);
}

Image create_image_array(Device& device, const ImageInfo& info, uint32_t layers) {
  return create_layers(device, info, layers, VK_IMAGE_VIEW_TYPE_2D_ARRAY);
}

ImageView create_level_view(Device& device, const Image& image, uint32_t level) {
  return create_view(device, image, VK_IMAGE_VIEW_TYPE_2D_ARRAY, image.written_as, VK_IMAGE_USAGE_STORAGE_BIT,
                     {image.aspect, level, 1, 0, image.layers});
}

std::jthread prefault(std::vector<std::span<std::byte>> pieces) {
  try {
    return std::jthread(touch_all, std::move(pieces));
  } catch (const std::system_error&) {  // without a thread, the device's own writes fault the pages
    return {};
  }
}

}  // namespace fire3dv::gpu
