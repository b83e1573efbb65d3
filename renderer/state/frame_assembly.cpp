#include "renderer/state/frame_assembly.h"

#include <algorithm>
#include <utility>

namespace fire3dv::state {

FrameAssembly::OpenFrame* FrameAssembly::frame_for(const wire::PoseFrameView& part) {
  OpenFrame* oldest = nullptr;
  for (OpenFrame& frame : frames_) {
    if (frame.header.sequence == part.header.sequence) return &frame;
    if (!oldest || frame.header.sequence < oldest->header.sequence) oldest = &frame;
  }
  // A free frame has sequence 0 and so counts as the oldest.
  if (oldest->header.sequence > part.header.sequence) return nullptr;
  if (oldest->header.sequence != 0) ++given_up_;
  close(*oldest);
  oldest->header = part.header;
  oldest->node_count = part.node_count;
  oldest->missing = part.node_count;
  oldest->chunks.resize((size_t{part.node_count} + kChunkPoses - 1) / kChunkPoses);
  return oldest;
}

// Makes room for poses [begin, end).
bool FrameAssembly::make_chunks(OpenFrame& frame, size_t begin, size_t end) {
  for (size_t i = begin / kChunkPoses; i * kChunkPoses < end; ++i) {
    if (frame.chunks[i]) continue;
    if (!spare_.empty()) {
      frame.chunks[i] = std::move(spare_.back());
      spare_.pop_back();
      continue;
    }
    if (!memory_.take(kChunkPoses + 1)) return false;  // one more for the bits
    frame.chunks[i] = std::make_unique<Chunk>();
  }
  return true;
}

FrameAssembly::Outcome FrameAssembly::add(const wire::PoseFrameView& part) {
  const uint64_t end = uint64_t{part.first_node} + part.poses.size();
  if (end > part.node_count || (part.poses.empty() && part.node_count != 0)) return Outcome::refused;
  OpenFrame* frame = frame_for(part);
  if (!frame) return Outcome::stale;
  // A frame is never put together from two steps, whatever the sender does with its sequence numbers.
  if (!(frame->header == part.header) || frame->node_count != part.node_count) return Outcome::refused;
  if (!make_chunks(*frame, part.first_node, end)) return Outcome::over_budget;

  uint32_t added = 0;
  for (size_t i = 0; i < part.poses.size(); ++i) {
    const size_t node = part.first_node + i;
    Chunk& chunk = *frame->chunks[node / kChunkPoses];
    if (chunk.have[node % kChunkPoses]) continue;
    chunk.have[node % kChunkPoses] = true;
    chunk.poses[node % kChunkPoses] = part.poses[i];
    ++added;
  }
  if (added == 0 && part.node_count != 0) return Outcome::stale;
  frame->missing -= added;
  if (frame->missing > 0) return Outcome::open;
  return make_whole(*frame) ? Outcome::whole : Outcome::over_budget;
}

bool FrameAssembly::make_whole(OpenFrame& frame) {
  if (!memory_.reserve(whole_poses_, frame.node_count)) return false;
  whole_header_ = frame.header;
  whole_poses_.clear();
  for (const std::unique_ptr<Chunk>& chunk : frame.chunks) {
    const size_t count = std::min(kChunkPoses, frame.node_count - whole_poses_.size());
    whole_poses_.insert(whole_poses_.end(), chunk->poses.begin(),
                        chunk->poses.begin() + static_cast<std::ptrdiff_t>(count));
  }
  return true;
}

void FrameAssembly::close(OpenFrame& frame) {
  for (std::unique_ptr<Chunk>& chunk : frame.chunks) {
    if (!chunk) continue;
    chunk->have.reset();
    spare_.push_back(std::move(chunk));
  }
  frame.chunks.clear();
  frame.header = {};
}

uint64_t FrameAssembly::close_up_to(uint64_t sequence) {
  uint64_t incomplete = 0;
  for (OpenFrame& frame : frames_) {
    if (frame.header.sequence == 0 || frame.header.sequence > sequence) continue;
    if (frame.header.sequence < sequence) ++incomplete;
    close(frame);
  }
  return incomplete;
}

void FrameAssembly::forget(uint64_t sequence) {
  for (OpenFrame& frame : frames_)
    if (frame.header.sequence == sequence) close(frame);
}

uint64_t FrameAssembly::take_given_up() {
  return std::exchange(given_up_, 0);
}

}  // namespace fire3dv::state
