#include "renderer/gpu/frame_ring.h"

#include <algorithm>
#include <utility>

namespace fire3dv::gpu {
namespace {

constexpr VkDeviceSize kAlignment = 256;  // maximum alignment of all uses in shaders and copies
constexpr VkDeviceSize kFirstChunk = 256 << 10;

constexpr VkPipelineStageFlags2 kAll = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                kTransfer = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;

}  // namespace

StagingRing::Piece StagingRing::allocate(VkDeviceSize size_bytes) {
  const VkDeviceSize size = (size_bytes + kAlignment - 1) / kAlignment * kAlignment;
  if (chunks_.empty() || used_ + size > chunks_.back().size_bytes) {
    const VkDeviceSize chunk =
        std::max({kFirstChunk, size, chunks_.empty() ? 0 : chunks_.back().size_bytes * 2});
    chunks_.push_back(create_buffer(device_, chunk,
                                    VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT,
                                    Memory::upload));
    used_ = 0;
  }
  const Buffer& chunk = chunks_.back();
  const Piece piece{chunk.mapped + used_, chunk.get(), used_, chunk.address + used_};
  used_ += size;
  return piece;
}

void StagingRing::reset() {
  if (chunks_.size() > 1) chunks_.erase(chunks_.begin(), chunks_.end() - 1);  // keep the largest
  used_ = 0;
  end_words_.clear();
}

namespace {

CommandPool create_pool(Device& device, uint32_t queue_family) {
  VkCommandPoolCreateInfo info{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  info.queueFamilyIndex = queue_family;
  VkCommandPool pool = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateCommandPool(device.handle(), &info, nullptr, &pool));
  return CommandPool(device, pool);
}

VkCommandBuffer create_commands(Device& device, const CommandPool& pool) {
  VkCommandBufferAllocateInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  info.commandPool = pool.get();
  info.commandBufferCount = 1;
  VkCommandBuffer commands = VK_NULL_HANDLE;
  FIRE3DV_VK(vkAllocateCommandBuffers(device.handle(), &info, &commands));
  return commands;
}

// Ticks between two timestamps; a counter of fewer than 64 bits may have wrapped around.
uint64_t ticks_between(uint64_t begin, uint64_t end, uint32_t valid_bits) {
  const uint64_t ticks = end - begin;
  return valid_bits < 64 ? ticks & ((uint64_t{1} << valid_bits) - 1) : ticks;
}

}  // namespace

FrameRing::FrameRing(Device& device) : device_(device), limits_(device) {
  slots_.reserve(kFramesInFlight);
  for (uint32_t i = 0; i < kFramesInFlight; ++i) {
    Slot& slot = slots_.emplace_back(device);
    slot.pool = create_pool(device, device.queues().main_family);
    slot.commands.before = create_commands(device, slot.pool);
    if (device.queues().async != AsyncQueue::none) {
      slot.async_pool = create_pool(device, device.queues().async_family);
      slot.commands.async_compute = create_commands(device, slot.async_pool);
      slot.commands.overlapped = create_commands(device, slot.pool);
      slot.commands.after = create_commands(device, slot.pool);
    }
    if (device.timestamp_bits() == 0) continue;
    VkQueryPoolCreateInfo queries{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
    queries.queryCount = kMaxTimestamps;
    VkQueryPool query_handle = VK_NULL_HANDLE;
    FIRE3DV_VK(vkCreateQueryPool(device.handle(), &queries, nullptr, &query_handle));
    slot.queries = QueryPool(device, query_handle);
  }
}

void FrameRing::end_early(uint64_t timeline_value) {
  if (timeline_value <= device_.completed()) return;
  for (const Slot& slot : slots_)
    if (slot.done_at == timeline_value) limits_.end(timeline_value, slot.staging.end_words());
}

bool FrameRing::wait_for_slot(int64_t timeout_ns) {
  return device_.wait_for(slots_[next_frame_ % kFramesInFlight].done_at, timeout_ns);
}

Recorder& FrameRing::begin() {
  frame_index_ = next_frame_++;
  slot_ = static_cast<uint32_t>(frame_index_ % kFramesInFlight);
  Slot& slot = slots_[slot_];
  device_.wait(slot.done_at);
  read_times(slot);
  device_.collect();
  limits_.release(slot.done_at);
  slot.staging.reset();
  slot.staging.set_has_limit(limits_.are_set());

  FIRE3DV_VK(vkResetCommandPool(device_.handle(), slot.pool.get(), 0));
  if (slot.async_pool) FIRE3DV_VK(vkResetCommandPool(device_.handle(), slot.async_pool.get(), 0));
  if (slot.queries) vkResetQueryPool(device_.handle(), slot.queries.get(), 0, kMaxTimestamps);
  VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  FIRE3DV_VK(vkBeginCommandBuffer(slot.commands.before, &info));
  slot.frame_index = frame_index_;
  std::optional<Fork> fork;
  if (slot.async_pool) fork = {slot.commands, device_.new_fork_number(), device_.async_timestamp_bits() != 0};
  return slot.recorder.emplace(slot.commands.before, slot.queries.get(), kMaxTimestamps, fork, timed_);
}

uint64_t FrameRing::submit(std::span<const SemaphoreSignal> waits, std::span<const SemaphoreSignal> signals) {
  Slot& slot = slots_[slot_];
  const std::optional<ForkedCommands> forked = slot.recorder->finish();
  slot.done_at =
      forked ? device_.submit(*forked, waits, signals) : device_.submit(slot.commands.before, waits, signals);
  limits_.submitted(slot.done_at, slot.staging.end_words());
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
    std::vector<uint64_t> ticks(2 * passes.size());
    FIRE3DV_VK(vkGetQueryPoolResults(device_.handle(), slot.queries.get(), 0,
                                     static_cast<uint32_t>(ticks.size()), ticks.size() * sizeof(uint64_t),
                                     ticks.data(), sizeof(uint64_t), VK_QUERY_RESULT_64_BIT));
    const double ms_per_tick = static_cast<double>(device_.limits().timestampPeriod) * 1e-6;
    std::optional<uint64_t> begin;
    for (const PassTimestamps& pass : passes) {
      const uint64_t pass_begin = ticks[pass.begin_query], pass_end = ticks[pass.end_query];
      const uint32_t bits = pass.async_compute ? device_.async_timestamp_bits() : device_.timestamp_bits();
      if (slot.recorder->times_passes()) {
        const auto ticks_taken = static_cast<double>(ticks_between(pass_begin, pass_end, bits));
        times.passes.push_back({pass.name, ticks_taken * ms_per_tick, pass.async_compute});
      }
      // Vulkan compares timestamps of one queue only. The main queue's span includes the async queue's work,
      // since it begins earlier and waits for it.
      if (pass.async_compute) continue;
      if (!begin) begin = pass_begin;
      times.total_ms = static_cast<double>(ticks_between(*begin, pass_end, bits)) * ms_per_tick;
    }
  }
  untaken_.push_back(std::move(times));
  constexpr size_t kMaxUntakenFrames = 1024;
  if (untaken_.size() > kMaxUntakenFrames) untaken_.erase(untaken_.begin());
}

void Patches::reserve(Device& device, Buffer& buffer, VkDeviceSize used_bytes, VkDeviceSize bytes) {
  if (buffer.size_bytes >= bytes) return;
  Buffer larger =
      create_buffer(device, bytes + bytes / 2, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, Memory::device);
  if (used_bytes) moves_.push_back({buffer.get(), larger.get(), {0, 0, used_bytes}});
  buffer = std::move(larger);  // the old buffer outlives the frame being recorded
}

void Patches::record(Recorder& recorder, StagingRing& staging) {
  if (empty()) return;
  const StagingRing::Piece piece = staging.write(std::span<const std::byte>(bytes_));
  recorder.pass("edits", {}, [&](VkCommandBuffer commands) {
    wait_for(commands, kAll, kTransfer);
    for (const Copy& move : moves_) vkCmdCopyBuffer(commands, move.from, move.to, 1, &move.region);
    if (!moves_.empty()) wait_for(commands, kTransfer, kTransfer);
    for (Copy copy : uploads_) {
      if (!copy.from) copy.region.srcOffset += piece.offset;
      vkCmdCopyBuffer(commands, copy.from ? copy.from : piece.buffer, copy.to, 1, &copy.region);
    }
    wait_for(commands, kTransfer, kAll);
  });
}

}  // namespace fire3dv::gpu
