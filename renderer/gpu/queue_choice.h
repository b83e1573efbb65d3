// Which queues of a device are opened: the main one, for everything, and where there is one a side queue, on
// which acceleration structures are built while the main one draws. The choice works on plain descriptions,
// so that it is tested without a GPU.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "renderer/gpu/vk.h"

namespace fire3dv::gpu {

enum class AsyncCompute : uint8_t {
  automatic,  // a side queue where there is one
  on,         // where there is none too: the same submissions, one after the other on the main queue
  off,        // one queue, one submission a frame
};

enum class SideQueue : uint8_t {
  none,
  compute_family,  // of a family that computes and does not draw
  main_family,     // a second one beside the main queue
  main_queue,      // the main one itself
};

struct QueueChoice {
  uint32_t main_family = 0;  // its queue 0
  SideQueue side = SideQueue::none;
  uint32_t side_family = 0;
  uint32_t side_index = 0;  // in its family

  bool two_families() const { return side != SideQueue::none && side_family != main_family; }
};

// Nothing when no family both draws and computes.
std::optional<QueueChoice> choose_queues(std::span<const VkQueueFamilyProperties> families,
                                         AsyncCompute wanted);
// Where acceleration structures are built.
const char* describe(SideQueue side);

}  // namespace fire3dv::gpu
