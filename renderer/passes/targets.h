// The images that a frame is drawn into; made anew when the size changes. Of several views at once only
// display exists, which holds them one below the other.
#pragma once

#include "renderer/gpu/resources.h"

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
};

}  // namespace fire3dv::passes
