// Selection of queues: a main queue for all work and, where available, an async compute queue for
// acceleration structures. It works on plain descriptions, so that tests need no GPU.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "renderer/gpu/device/vk.h"

namespace fire3dv::gpu {

enum class AsyncCompute : uint8_t {
  automatic,  // an async compute queue where there is one
  on,         // always; without a second queue the submissions are serialised on the main queue
  off,        // one queue, one submission a frame
};

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

}  // namespace fire3dv::gpu
