#include "renderer/gpu/frame_ring.h"

#include <algorithm>

namespace fire3dv::gpu {

FrameRing::FrameRing(Device& device) : device_(device) {
  slots_.reserve(kFramesInFlight);
  for (uint32_t i = 0; i < kFramesInFlight; ++i) {
    Slot& slot = slots_.emplace_back(device);
    VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool.queueFamilyIndex = device.queue_family();
    VkCommandPool pool_handle = VK_NULL_HANDLE;
    FIRE3DV_VK(vkCreateCommandPool(device.handle(), &pool, nullptr, &pool_handle));
    slot.pool = CommandPool(device, pool_handle);

    VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    allocate.commandPool = pool_handle;
    allocate.commandBufferCount = 1;
    FIRE3DV_VK(vkAllocateCommandBuffers(device.handle(), &allocate, &slot.commands));

    VkQueryPoolCreateInfo queries{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
    queries.queryCount = kMaxTimestamps;
    VkQueryPool query_handle = VK_NULL_HANDLE;
    FIRE3DV_VK(vkCreateQueryPool(device.handle(), &queries, nullptr, &query_handle));
    slot.queries = QueryPool(device, query_handle);
  }
}

Recorder& FrameRing::begin() {
  frame_index_ = next_frame_++;
  slot_ = static_cast<uint32_t>(frame_index_ % kFramesInFlight);
  Slot& slot = slots_[slot_];
  device_.wait(slot.done_at);
  read_times(slot);
  device_.collect();
  slot.belt.reset();

  FIRE3DV_VK(vkResetCommandPool(device_.handle(), slot.pool.get(), 0));
  vkResetQueryPool(device_.handle(), slot.queries.get(), 0, kMaxTimestamps);
  VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  FIRE3DV_VK(vkBeginCommandBuffer(slot.commands, &info));
  slot.frame_index = frame_index_;
  return slot.recorder.emplace(slot.commands, slot.queries.get(), kMaxTimestamps);
}

uint64_t FrameRing::submit(std::span<const SemaphoreSignal> waits, std::span<const SemaphoreSignal> signals) {
  Slot& slot = slots_[slot_];
  FIRE3DV_VK(vkEndCommandBuffer(slot.commands));
  slot.done_at = device_.submit(slot.commands, waits, signals);
  slot.times_pending = true;
  return slot.done_at;
}

std::vector<FrameTimes> FrameRing::take_finished() {
  // Oldest first.
  std::vector<Slot*> order;
  for (Slot& slot : slots_) order.push_back(&slot);
  std::sort(order.begin(), order.end(), [](auto* a, auto* b) { return a->frame_index < b->frame_index; });
  const uint64_t done = device_.completed();
  for (Slot* slot : order) {
    if (slot->done_at <= done) read_times(*slot);
  }
  return std::exchange(untaken_, {});
}

void FrameRing::read_times(Slot& slot) {
  if (!slot.times_pending) return;
  slot.times_pending = false;
  const std::vector<PassTimestamps>& passes = slot.recorder->timestamps();
  FrameTimes times;
  times.frame_index = slot.frame_index;
  if (!passes.empty()) {
    std::vector<uint64_t> ticks(passes.back().end_query + 1);
    FIRE3DV_VK(vkGetQueryPoolResults(device_.handle(), slot.queries.get(), 0, static_cast<uint32_t>(ticks.size()),
                                     ticks.size() * sizeof(uint64_t), ticks.data(), sizeof(uint64_t),
                                     VK_QUERY_RESULT_64_BIT));
    const double ms_per_tick = static_cast<double>(device_.limits().timestampPeriod) * 1e-6;
    for (const PassTimestamps& pass : passes) {
      times.passes.push_back({pass.name, static_cast<double>(ticks[pass.end_query] - ticks[pass.begin_query]) * ms_per_tick});
    }
    times.total_ms = static_cast<double>(ticks.back() - ticks.front()) * ms_per_tick;
  }
  finished_ = times;
  untaken_.push_back(std::move(times));
  constexpr size_t kKeptWhenNobodyTakes = 1024;
  if (untaken_.size() > kKeptWhenNobodyTakes) untaken_.erase(untaken_.begin());
}

}  // namespace fire3dv::gpu
