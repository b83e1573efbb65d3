// Batches of draws in images with a time limit: between two of them the device finishes what it draws, so
// that an image that has reached its limit ends with its batch.
#pragma once

#include <algorithm>
#include <cstdint>

#include "renderer/gpu/recorder.h"

namespace fire3dv::passes {

// Triangles of a batch, each of which may cover the whole area: about 0.1 s of a CPU device.
inline uint32_t triangles_per_batch(VkExtent2D area) {
  constexpr uint64_t kFragments = uint64_t{4} << 20, kLeast = 64, kMost = uint64_t{1} << 16;
  const uint64_t pixels = std::max<uint64_t>(uint64_t{area.width} * area.height, 1);
  return static_cast<uint32_t>(std::clamp(kFragments / pixels, kLeast, kMost));
}

// Ends the batch. The caller begins rendering again, with the attachments as they are.
inline void end_batch(VkCommandBuffer commands) {
  vkCmdEndRendering(commands);
  constexpr VkPipelineStageFlags2 kDraws = VK_PIPELINE_STAGE_2_ALL_GRAPHICS_BIT;
  gpu::wait_for(commands, kDraws, kDraws);
}

}  // namespace fire3dv::passes
