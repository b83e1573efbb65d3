#include "renderer/gpu/loader_commands.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <utility>

namespace fire3dv::gpu {
namespace {

constexpr VkDeviceSize kStagingBytes = 32 << 20;

VkBufferImageCopy level_copy(const Image& image, uint32_t level) {
  VkBufferImageCopy copy{};
  copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, level, 0, image.layers};
  copy.imageExtent = {std::max(image.extent.width >> level, 1u), std::max(image.extent.height >> level, 1u),
                      1};
  return copy;
}

}  // namespace

LoaderCommands::LoaderCommands(Device& device) : device_(device) {
  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.queueFamilyIndex = device.queue_family();
  pool.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  VkCommandPool pool_handle = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateCommandPool(device.handle(), &pool, nullptr, &pool_handle));
  pool_ = CommandPool(device, pool_handle);
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool_handle;
  allocate.commandBufferCount = 1;
  FIRE3DV_VK(vkAllocateCommandBuffers(device.handle(), &allocate, &commands_));
}

LoaderCommands::~LoaderCommands() {
  // An exception abandons the recorded work: some of its target buffers are gone.
  if (std::uncaught_exceptions() == 0) finish();
}

Recorder& LoaderCommands::recorder() {
  if (!recorder_) {
    finish();
    FIRE3DV_VK(vkResetCommandPool(device_.handle(), pool_.get(), 0));
    VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    FIRE3DV_VK(vkBeginCommandBuffer(commands_, &info));
    recorder_.emplace(commands_, VK_NULL_HANDLE, 0);
  }
  return *recorder_;
}

void LoaderCommands::submit() {
  if (!recorder_) return;
  FIRE3DV_VK(vkEndCommandBuffer(commands_));
  submitted_ = device_.submit(commands_);
  recorder_.reset();
}

void LoaderCommands::finish() {
  submit();
  if (submitted_ == 0) return;
  device_.wait(std::exchange(submitted_, 0));
  device_.collect();
  staged_ = 0;
}

std::byte* LoaderCommands::stage(VkDeviceSize bytes, VkDeviceSize& offset) {
  if (submitted_ != 0 || staged_ + bytes > staging_.size_bytes) finish();
  if (bytes > staging_.size_bytes)
    staging_ = create_buffer(device_, std::max(bytes, kStagingBytes), 0, Memory::upload);
  offset = staged_;
  staged_ = (staged_ + bytes + 15) / 16 * 16;
  return staging_.mapped + offset;
}

void LoaderCommands::upload_piece(Buffer& buffer, VkDeviceSize offset, VkDeviceSize size,
                                  const std::function<void(std::span<std::byte>)>& fill) {
  if (buffer.mapped) return fill({buffer.mapped + offset, size});
  VkBufferCopy copy{0, offset, size};
  std::byte* mapped = stage(size, copy.srcOffset);
  fill({mapped, size});
  recorder().pass("upload", {Use(buffer, access::transfer_write)}, [&](VkCommandBuffer commands) {
    vkCmdCopyBuffer(commands, staging_.get(), buffer.get(), 1, &copy);
  });
}

void LoaderCommands::upload(Buffer& buffer, VkDeviceSize offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const size_t size = std::min<size_t>(bytes.size(), kStagingBytes);
    upload_piece(buffer, offset, size,
                 [&](std::span<std::byte> to) { std::memcpy(to.data(), bytes.data(), size); });
    offset += size;
    bytes = bytes.subspan(size);
  }
}

void LoaderCommands::upload(Buffer& buffer, VkDeviceSize size, VkDeviceSize unit,
                            const std::function<void(VkDeviceSize offset, std::span<std::byte> to)>& fill) {
  const VkDeviceSize most = buffer.mapped ? size : kStagingBytes / unit * unit;
  for (VkDeviceSize offset = 0; offset < size; offset += most) {
    upload_piece(buffer, offset, std::min(most, size - offset),
                 [&](std::span<std::byte> to) { fill(offset, to); });
  }
}

void LoaderCommands::upload_level(Image& image, uint32_t level, std::span<const std::byte> bytes) {
  VkBufferImageCopy copy = level_copy(image, level);
  std::byte* mapped = stage(bytes.size(), copy.bufferOffset);
  std::memcpy(mapped, bytes.data(), bytes.size());
  recorder().pass("upload", {Use(image, access::transfer_write)}, [&](VkCommandBuffer commands) {
    vkCmdCopyBufferToImage(commands, staging_.get(), image.get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
                           &copy);
  });
}

void LoaderCommands::upload_levels(Image& image, std::span<const std::span<const std::byte>> levels) {
  VkDeviceSize bytes = 0;
  for (const std::span<const std::byte>& level : levels) bytes += level.size();
  VkDeviceSize offset = 0;
  std::byte* mapped = stage(bytes, offset);
  std::vector<VkBufferImageCopy> copies;
  for (uint32_t level = 0; level < levels.size(); ++level) {
    VkBufferImageCopy& copy = copies.emplace_back(level_copy(image, level));
    copy.bufferOffset = offset;
    std::memcpy(mapped, levels[level].data(), levels[level].size());
    mapped += levels[level].size();
    offset += levels[level].size();
  }
  recorder().pass("upload", {Use(image, access::transfer_write, true)}, [&](VkCommandBuffer commands) {
    vkCmdCopyBufferToImage(commands, staging_.get(), image.get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                           static_cast<uint32_t>(copies.size()), copies.data());
  });
  constexpr Access sample{VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                          VK_ACCESS_2_SHADER_READ_BIT, false, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
  recorder().transition({Use(image, sample)});
}

void LoaderCommands::download_level(Image& image, uint32_t level, Buffer& to, VkDeviceSize offset) {
  VkBufferImageCopy copy = level_copy(image, level);
  copy.bufferOffset = offset;
  recorder().pass("download", {Use(image, access::transfer_read), Use(to, access::transfer_write)},
                  [&](VkCommandBuffer commands) {
                    vkCmdCopyImageToBuffer(commands, image.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                           to.get(), 1, &copy);
                  });
}

}  // namespace fire3dv::gpu
