// Render targets of one size: images, buffers and the descriptor sets for them. With several views, `display`
// is the only image and stacks them vertically.
#pragma once

#include "renderer/gpu/pipelines/descriptors.h"
#include "renderer/gpu/resources.h"
#include "renderer/passes/visibility/cluster_target.h"

namespace fire3dv::passes {

struct Targets {
  Targets(gpu::Device& device, VkExtent2D extent, uint32_t views, VkSampleCountFlagBits samples);

  VkExtent2D extent{};  // of a view
  uint32_t views = 1;
  VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
  gpu::Image hdr;       // linear HDR colour, multisampled
  gpu::Image depth;     // reversed, multisampled
  gpu::Image display;   // tone-mapped, resolved, sRGB-encoded RGBA8
  gpu::Image smoothed;  // display after FXAA

  // Buffers of VisibilityPass and ShadowPass, where these exist.
  ClusterTarget visibility;    // uint64_t[view][pixel][sample]
  gpu::Buffer shadow_mask;     // uint32_t[pixel][word]
  gpu::Buffer shadow_entries;  // gpu_types::RayEntry[pixel][word]
  gpu::Buffer listed_rays;     // gpu_types::ListedRay[]
  // Each set belongs to the pass that writes it.
  gpu::DescriptorSet shade_set, tone_map_set, fxaa_set, stale_overlay_set, overlay_set;
  VkImageView stale_overlay_view = VK_NULL_HANDLE, overlay_view = VK_NULL_HANDLE;  // of the last two
};

// Approximate device memory of the targets.
VkDeviceSize bytes_of(const Targets& targets);

}  // namespace fire3dv::passes
