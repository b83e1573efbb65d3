#include "renderer/passes/resources/targets.h"

#include "renderer/gpu/device/device.h"

namespace fire3dv::passes {

Targets::Targets(gpu::Device& device, VkExtent2D size, uint32_t view_count,
                 VkSampleCountFlagBits sample_count)
    : extent(size), views(view_count), samples(sample_count) {
  const gpu::ImageInfo finished{
      VK_FORMAT_R8G8B8A8_UNORM,
      {size.width, size.height * views},
      VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
      1};
  display = gpu::create_image(device, finished);
  if (views > 1) return;
  const bool computed = samples == VK_SAMPLE_COUNT_1_BIT || device.report().multisample_storage;
  const VkImageUsageFlags hdr_usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT |
                                      (computed ? VK_IMAGE_USAGE_STORAGE_BIT : 0);
  hdr = gpu::create_image(device, {VK_FORMAT_R16G16B16A16_SFLOAT, size, hdr_usage, 1, samples});
  depth = gpu::create_image(
      device, {VK_FORMAT_D32_SFLOAT, size, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, 1, samples});
  smoothed = gpu::create_image(device, finished);
}

VkDeviceSize bytes_of(const Targets& targets) {
  const VkDeviceSize pixels = VkDeviceSize{targets.extent.width} * targets.extent.height * targets.views;
  // The levels add a third of the light image.
  const VkDeviceSize bloom_bytes = targets.bloom ? pixels * 8 * 4 / 3 : 0;
  const VkDeviceSize sample_bytes = targets.hdr ? 8 + 4 : 0;
  const VkDeviceSize finished_bytes = 4 + (targets.smoothed ? 4 : 0) + (targets.layers ? 4 : 0);
  return pixels * (targets.samples * sample_bytes + finished_bytes) + bloom_bytes +
         targets.visibility.buffer.size_bytes + targets.shadow_mask.size_bytes +
         targets.shadow_entries.size_bytes + targets.listed_rays.size_bytes + targets.ray_effects.size_bytes;
}

}  // namespace fire3dv::passes
