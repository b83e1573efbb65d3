// Queues of a device: a main queue for all work and, where available, an async compute queue for acceleration
// structures. Their selection, and the submissions of a frame that uses both. All of it works on plain
// descriptions, so that tests need no GPU.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "renderer/gpu/device/async_compute.h"
#include "renderer/gpu/device/vk.h"

namespace fire3dv::gpu {

enum class AsyncQueue : uint8_t {
  none,
  compute_family,  // queue of a compute-only family
  main_family,     // second queue of the main family
  main_queue,      // the main queue itself
};

struct QueueChoice {
  uint32_t main_family = 0;  // queue 0 of this family
  AsyncQueue async = AsyncQueue::none;
  uint32_t async_family = 0;
  uint32_t async_index = 0;  // in its family

  bool two_families() const { return async != AsyncQueue::none && async_family != main_family; }
};

// Returns nothing when no family supports both graphics and compute.
std::optional<QueueChoice> choose_queues(std::span<const VkQueueFamilyProperties> families,
                                         AsyncCompute wanted);
// Text for the user: the queue that builds acceleration structures.
const char* describe(AsyncQueue async);

// Submissions of a frame with one piece on the async compute queue. Two timeline values order the pieces
// across queues; the main queue's own order needs no semaphore.
//
//   main   [before] --n--+--> [overlapped] --------> [after] --> the frame's own value
//                        |                             ^
//   async                +--> [async_compute] -------n+1-------+
//
// The last piece always waits for the async piece, so the frame's value covers both queues. Consumers, such
// as the retirement of objects, therefore need one timeline only. The wait also orders the next frame behind
// this one on both queues: its async piece waits for its first main piece. No resource is overwritten while
// it is read.
struct ForkedCommands {
  VkCommandBuffer before = VK_NULL_HANDLE;
  VkCommandBuffer async_compute = VK_NULL_HANDLE;  // on the async compute queue
  VkCommandBuffer overlapped = VK_NULL_HANDLE;
  VkCommandBuffer after = VK_NULL_HANDLE;
};

VkSemaphoreSubmitInfo semaphore_submit(VkSemaphore semaphore, uint64_t value,
                                       VkPipelineStageFlags2 stage = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);

// Arguments of vkQueueSubmit2 in call order: each value is signalled by an earlier submission, so both queues
// may be the same queue. Not copyable, because Vulkan's structures point into the object.
class ForkedSubmit {
 public:
  // number: count of the device's forks, from 1. waits, signals: semaphores of the last piece.
  ForkedSubmit(const ForkedCommands& commands, VkSemaphore fork_timeline, uint64_t number,
               std::vector<VkSemaphoreSubmitInfo> waits, std::vector<VkSemaphoreSubmitInfo> signals);
  ForkedSubmit(const ForkedSubmit&) = delete;
  ForkedSubmit& operator=(const ForkedSubmit&) = delete;

  const VkSubmitInfo2& before() const { return submits_[0]; }                       // main queue
  const VkSubmitInfo2& async_compute() const { return submits_[1]; }                // async compute queue
  std::span<const VkSubmitInfo2> rest() const { return {submits_.data() + 2, 2}; }  // main queue

 private:
  std::array<VkCommandBufferSubmitInfo, 4> commands_{};
  VkSemaphoreSubmitInfo before_done_, async_done_;
  std::vector<VkSemaphoreSubmitInfo> waits_, signals_;
  std::array<VkSubmitInfo2, 4> submits_{};
};

}  // namespace fire3dv::gpu
