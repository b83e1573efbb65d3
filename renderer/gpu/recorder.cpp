#include "renderer/gpu/recorder.h"

#include <algorithm>
#include <utility>

#include "base/error.h"

namespace fire3dv::gpu {
namespace {

struct Dependency {
  bool needed = false;
  VkPipelineStageFlags2 src_stages = 0;
  VkAccessFlags2 src_access = 0;
};

// Returns the dependency of an access on the accesses since the last write, then records the access in
// `state`.
Dependency depend(UseState& state, const Access& next, bool changes_layout) {
  Dependency dependency;
  if (next.writes || changes_layout) {
    // Waits for every earlier access: write after write, write after read.
    dependency.needed = changes_layout || state.write_stages || state.read_stages;
    dependency.src_stages = state.write_stages | state.read_stages;
    dependency.src_access = state.write_access;
    state.write_stages = next.writes ? next.stages : VK_PIPELINE_STAGE_2_NONE;
    state.write_access = next.writes ? next.access : VK_ACCESS_2_NONE;
    state.read_stages = next.writes ? VK_PIPELINE_STAGE_2_NONE : next.stages;
    // The write is not yet visible to any later access, not even in its own stage.
    state.visible_stages = state.visible_access = 0;
    if (!next.writes) {
      // A layout change without a write: its barrier makes the image visible to this reader. Later readers
      // wait through this reader's stages.
      state.write_stages = next.stages;
      state.visible_stages = next.stages;
      state.visible_access = next.access;
    }
    return dependency;
  }
  const bool visible = (state.visible_stages & next.stages) == next.stages &&
                       (state.visible_access & next.access) == next.access;
  if (state.write_stages && !visible) {
    dependency.needed = true;
    dependency.src_stages = state.write_stages;
    dependency.src_access = state.write_access;
    state.visible_stages |= next.stages;
    state.visible_access |= next.access;
  }
  state.read_stages |= next.stages;
  return dependency;
}

}  // namespace

void wait_for(VkCommandBuffer commands, VkPipelineStageFlags2 before, VkPipelineStageFlags2 after) {
  constexpr VkAccessFlags2 kAnyAccess = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
  VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
  barrier.srcStageMask = before;
  barrier.srcAccessMask = kAnyAccess;
  barrier.dstStageMask = after;
  barrier.dstAccessMask = kAnyAccess;
  VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  info.memoryBarrierCount = 1;
  info.pMemoryBarriers = &barrier;
  vkCmdPipelineBarrier2(commands, &info);
}

void Recorder::pass(const char* name, std::span<const Use> uses,
                    const std::function<void(VkCommandBuffer)>& record) {
  copy_before_overwrite(uses);
  barriers(uses);
  begin_frame_time();
  if (overlaps_copies_now()) begin_copies();
  const std::optional<uint32_t> begin_query = write_timestamps_begin();
  record(commands_);
  write_timestamps_end(name, begin_query);
}

void Recorder::copy_at_end(const Buffer& from, Buffer& into, std::vector<VkBufferCopy> regions) {
  const auto is_same = [&](const CopyAtEnd& copy) { return copy.into == &into; };
  if (std::any_of(copies_begun_.begin(), copies_begun_.end(), is_same)) end_copies();
  if (std::any_of(copies_at_end_.begin(), copies_at_end_.end(), is_same)) record_copies();
  copies_at_end_.push_back({from.get(), &into, std::move(regions)});
}

void Recorder::copy_before_overwrite(std::span<const Use> uses) {
  const auto overwrites = [&](const std::vector<CopyAtEnd>& copies) {
    return std::any_of(copies.begin(), copies.end(), [&](const CopyAtEnd& copy) {
      return std::any_of(uses.begin(), uses.end(), [&](const Use& use) {
        return use.buffer && use.access.writes && copy.from == use.buffer->get();
      });
    });
  };
  if (overwrites(copies_begun_)) end_copies();
  if (overwrites(copies_at_end_)) record_copies();
}

bool Recorder::overlaps_copies_now() const {
  return overlaps_copies_ && piece_ != Piece::async_compute && !copies_at_end_.empty();
}

// The source buffer may have been replaced, so its use state is unknown. The copies therefore wait for all
// earlier commands, and all later commands wait for them.
void Recorder::record_copies() {
  if (copies_at_end_.empty()) return;
  end_copies();
  begin_copies();
  end_copies();
}

void Recorder::begin_copies() {
  overlaps_copies_ = false;
  copies_begun_ = std::exchange(copies_at_end_, {});
  std::vector<Use> written;
  for (const CopyAtEnd& copy : copies_begun_) written.emplace_back(*copy.into, access::transfer_write);
  barriers(written);
  wait_for(commands_, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, access::transfer_read.stages);
  const std::optional<uint32_t> begin_query = write_timestamps_begin();
  for (const CopyAtEnd& copy : copies_begun_) {
    vkCmdCopyBuffer(commands_, copy.from, copy.into->get(), static_cast<uint32_t>(copy.regions.size()),
                    copy.regions.data());
  }
  write_timestamps_end("counts", begin_query);
}

void Recorder::end_copies() {
  if (copies_begun_.empty()) return;
  std::vector<Use> host_reads;
  for (const CopyAtEnd& copy : std::exchange(copies_begun_, {}))
    host_reads.emplace_back(*copy.into, access::host_read);
  barriers(host_reads);
  wait_for(commands_, access::transfer_read.stages, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT);
}

void Recorder::transition(std::initializer_list<Use> uses) {
  copy_before_overwrite(uses);
  barriers(std::span<const Use>(uses.begin(), uses.size()));
}

void Recorder::async_compute(const char* wait_name, const std::function<void()>& record) {
  if (!fork_) return record();
  FIRE3DV_ASSERT(piece_ == Piece::before);
  FIRE3DV_VK(vkEndCommandBuffer(commands_));
  continue_in(fork_->commands.async_compute, Piece::async_compute);
  record();
  FIRE3DV_VK(vkEndCommandBuffer(commands_));
  continue_in(fork_->commands.overlapped, Piece::overlapped);
  wait_name_ = wait_name;
}

std::optional<ForkedCommands> Recorder::finish() {
  record_copies();
  end_copies();
  if (piece_ == Piece::overlapped) join();
  end_frame_time();
  FIRE3DV_VK(vkEndCommandBuffer(commands_));
  if (piece_ == Piece::before) return std::nullopt;
  return fork_->commands;
}

void Recorder::join() {
  const std::optional<uint32_t> begin_query = write_timestamps_begin();
  FIRE3DV_VK(vkEndCommandBuffer(commands_));
  continue_in(fork_->commands.after, Piece::after);
  write_timestamps_end(wait_name_, begin_query);
}

void Recorder::continue_in(VkCommandBuffer commands, Piece piece) {
  commands_ = commands;
  piece_ = piece;
  VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  FIRE3DV_VK(vkBeginCommandBuffer(commands_, &info));
}

// The frame's time starts at the first pass of the main queue.
void Recorder::begin_frame_time() {
  if (times_passes() || !queries_ || next_query_ != 0 || piece_ == Piece::async_compute) return;
  vkCmdWriteTimestamp2(commands_, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries_, 0);
  next_query_ = 2;
}

void Recorder::end_frame_time() {
  if (times_passes() || next_query_ == 0) return;
  vkCmdWriteTimestamp2(commands_, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries_, 1);
  timestamps_.push_back({"frame", 0, 1, false});
}

std::optional<uint32_t> Recorder::write_timestamps_begin() {
  const bool timed = times_passes() && queries_ && next_query_ + 2 <= max_queries_;
  if (!timed || (piece_ == Piece::async_compute && !fork_->times_async)) return std::nullopt;
  vkCmdWriteTimestamp2(commands_, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries_, next_query_);
  next_query_ += 2;
  return next_query_ - 2;
}

void Recorder::write_timestamps_end(const char* name, std::optional<uint32_t> begin_query) {
  if (!begin_query) return;
  vkCmdWriteTimestamp2(commands_, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries_, *begin_query + 1);
  timestamps_.push_back({name, *begin_query, *begin_query + 1, piece_ == Piece::async_compute});
}

// True if a resource has to wait for the async piece, which may still run.
bool Recorder::depends_on_async(std::span<const Use> uses) const {
  return std::any_of(uses.begin(), uses.end(), [&](const Use& use) {
    const UseState& state = use.buffer ? use.buffer->use : use.image->use;
    return state.async_write == fork_->number || (use.access.writes && state.async_read == fork_->number);
  });
}

// Semaphores between the pieces of a frame make earlier writes visible to later pieces on both queues. So the
// async queue needs barriers against its own writes only, and the main queue needs none against it. Stages of
// the main queue would also be invalid in a barrier on the async queue.
bool Recorder::is_ordered_by_fork(UseState& state, const Access& next) {
  if (piece_ != Piece::async_compute) {
    if (state.async_write) state = {.layout = state.layout, .async_read = state.async_read};
    return false;
  }
  if (state.async_write == fork_->number) return false;
  if (next.writes) {
    const bool read_here = state.async_read == fork_->number;
    state = {.layout = state.layout, .async_write = fork_->number};
    if (!read_here) {
      state.write_stages = next.stages;
      state.write_access = next.access;
      return true;
    }
    state.read_stages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    return false;
  }
  state.async_read = fork_->number;  // the main queue's state stays as it is
  return true;
}

void Recorder::barriers(std::span<const Use> uses) {
  std::vector<VkImageMemoryBarrier2> image_barriers;
  VkMemoryBarrier2 memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
  bool memory_needed = false;
  if (piece_ == Piece::overlapped && depends_on_async(uses)) join();
  for (const Use& use : uses) {
    FIRE3DV_ASSERT(use.buffer || piece_ != Piece::async_compute);
    if (is_ordered_by_fork(use.buffer ? use.buffer->use : use.image->use, use.access)) continue;
    if (use.buffer) {
      const Dependency d = depend(use.buffer->use, use.access, false);
      if (!d.needed) continue;
      // One memory barrier covers all buffers: drivers make no difference.
      memory_needed = true;
      memory.srcStageMask |= d.src_stages;
      memory.srcAccessMask |= d.src_access;
      memory.dstStageMask |= use.access.stages;
      memory.dstAccessMask |= use.access.access;
      continue;
    }
    Image& image = *use.image;
    const bool changes_layout = use.discard || image.use.layout != use.access.layout;
    const Dependency d = depend(image.use, use.access, changes_layout);
    if (!d.needed) continue;
    VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
    barrier.srcStageMask = d.src_stages;
    barrier.srcAccessMask = d.src_access;
    barrier.dstStageMask = use.access.stages;
    barrier.dstAccessMask = use.access.access;
    barrier.oldLayout = use.discard ? VK_IMAGE_LAYOUT_UNDEFINED : image.use.layout;
    barrier.newLayout = use.access.layout;
    barrier.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image.get();
    barrier.subresourceRange = {image.aspect, 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS};
    image_barriers.push_back(barrier);
    image.use.layout = use.access.layout;
  }
  if (!memory_needed && image_barriers.empty()) return;
  VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  info.memoryBarrierCount = memory_needed ? 1 : 0;
  info.pMemoryBarriers = &memory;
  info.imageMemoryBarrierCount = static_cast<uint32_t>(image_barriers.size());
  info.pImageMemoryBarriers = image_barriers.data();
  vkCmdPipelineBarrier2(commands_, &info);
}

}  // namespace fire3dv::gpu
