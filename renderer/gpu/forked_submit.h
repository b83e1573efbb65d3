// The submissions of a frame of which one piece runs on the side queue. Two semaphore values tie the pieces
// together; what follows from their order on the main queue needs none:
//
//   main   [before] --n--+--> [beside] -----------> [after] --> the frame's own value
//                        |                             ^
//   side                 +--> [aside] -------n+1-------+
//
// The last piece waits whether or not it uses what came of the piece aside. So the frame's value covers both
// queues, and whoever waits for it, the retirement of objects among them, needs to know of one timeline
// alone. It also orders the next frame behind this one: all of it comes after that wait on the main queue,
// and its piece aside waits for its first one. Nothing is overwritten while it is read.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/gpu/vk.h"

namespace fire3dv::gpu {

struct ForkedCommands {
  VkCommandBuffer before = VK_NULL_HANDLE;
  VkCommandBuffer aside = VK_NULL_HANDLE;  // of the side queue
  VkCommandBuffer beside = VK_NULL_HANDLE;
  VkCommandBuffer after = VK_NULL_HANDLE;
};

VkSemaphoreSubmitInfo semaphore_submit(VkSemaphore semaphore, uint64_t value,
                                       VkPipelineStageFlags2 stage = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);

// What vkQueueSubmit2 takes, in the order in which it is called: so that each value is signalled by what is
// submitted already, and both queues may be the same one. Not copied: Vulkan's structures point into it.
class ForkedSubmit {
 public:
  // number: of the device's forks, from 1. waits, signals: of the last piece.
  ForkedSubmit(const ForkedCommands& commands, VkSemaphore fork_timeline, uint64_t number,
               std::vector<VkSemaphoreSubmitInfo> waits, std::vector<VkSemaphoreSubmitInfo> signals);
  ForkedSubmit(const ForkedSubmit&) = delete;
  ForkedSubmit& operator=(const ForkedSubmit&) = delete;

  const VkSubmitInfo2& before() const { return submits_[0]; }                       // main
  const VkSubmitInfo2& aside() const { return submits_[1]; }                        // side
  std::span<const VkSubmitInfo2> rest() const { return {submits_.data() + 2, 2}; }  // main

 private:
  std::array<VkCommandBufferSubmitInfo, 4> commands_{};
  VkSemaphoreSubmitInfo before_done_, aside_done_;
  std::vector<VkSemaphoreSubmitInfo> waits_, signals_;
  std::array<VkSubmitInfo2, 4> submits_{};
};

}  // namespace fire3dv::gpu
