// What a frame is drawn into: images and buffers of one size, and the descriptor sets by which passes reach
// them. Of several views at once only `display` exists of the images, which holds them one below the other.
#pragma once

#include "renderer/gpu/descriptors.h"
#include "renderer/gpu/resources.h"
#include "renderer/passes/cluster_target.h"

namespace fire3dv::passes {

struct Targets {
  Targets(gpu::Device& device, VkExtent2D extent, uint32_t views, VkSampleCountFlagBits samples);

  VkExtent2D extent{};  // of a view
  uint32_t views = 1;
  VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
  gpu::Image hdr;       // linear HDR colour, multisampled
  gpu::Image depth;     // reversed, multisampled
  gpu::Image display;   // tone-mapped, resolved, sRGB-encoded RGBA8
  gpu::Image smoothed;  // the same after FXAA

  // Of VisibilityPass and ShadowPass, where there are any.
  ClusterTarget visibility;    // uint64_t[view][pixel][sample]
  gpu::Buffer shadow_mask;     // uint32_t[pixel][word]
  gpu::Buffer shadow_entries;  // gpu_types::RayEntry[pixel][word]
  gpu::Buffer found_rays;      // gpu_types::FoundRay[]
  // Each is the pass's that wrote it.
  gpu::DescriptorSet shade_set, tone_map_set, fxaa_set, held_mark_set, overlay_set;
  VkImageView held_mark_view = VK_NULL_HANDLE, overlay_view = VK_NULL_HANDLE;  // of the last two
};

// About so much memory of the device.
VkDeviceSize bytes_of(const Targets& targets);

}  // namespace fire3dv::passes
