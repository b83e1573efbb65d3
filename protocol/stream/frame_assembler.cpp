#include "protocol/stream/frame_assembler.h"

#include <algorithm>

namespace fire3dv::stream {

FrameAssembler::OpenFrame* FrameAssembler::frame_of(const wire::PoseFrameView& part) {
  if (OpenFrame* open = frames_.find(part.header.sequence)) return open;
  OpenFrame* frame = frames_.open(part.header.sequence);
  if (!frame) return nullptr;
  frame->header = part.header;
  frame->node_count = part.node_count;
  frame->chunks.resize((size_t{part.node_count} + kChunkPoses - 1) / kChunkPoses);
  return frame;
}

// Allocates the chunks of poses [begin, end).
bool FrameAssembler::make_chunks(OpenFrame& frame, size_t begin, size_t end) {
  for (size_t i = begin / kChunkPoses; i * kChunkPoses < end; ++i) {
    if (frame.chunks[i]) continue;
    if (!memory_.take(kChunkPoses + 1)) return false;  // one more for the set of arrived poses
    frame.chunks[i] = std::make_unique<Chunk>();
  }
  return true;
}

FrameAssembler::Outcome FrameAssembler::add(const wire::PoseFrameView& part) {
  const uint64_t end = uint64_t{part.first_node} + part.poses.size();
  if (end > part.node_count || (part.poses.empty() && part.node_count != 0)) return Outcome::refused;
  OpenFrame* frame = frame_of(part);
  if (!frame) return Outcome::stale;
  if (!(frame->header == part.header) || frame->node_count != part.node_count) return Outcome::refused;
  if (!make_chunks(*frame, part.first_node, end)) return Outcome::over_budget;

  const uint32_t arrived_before = frame->arrived.size();
  for (size_t i = 0; i < part.poses.size(); ++i) {
    const size_t node = part.first_node + i;
    if (frame->arrived.insert(static_cast<uint32_t>(node)))
      (*frame->chunks[node / kChunkPoses])[node % kChunkPoses] = part.poses[i];
  }
  if (frame->arrived.size() == arrived_before && part.node_count != 0) return Outcome::stale;
  if (frame->arrived.size() < part.node_count) return Outcome::open;
  return make_whole(*frame) ? Outcome::whole : Outcome::over_budget;
}

bool FrameAssembler::make_whole(const OpenFrame& frame) {
  if (!memory_.reserve(whole_poses_, frame.node_count)) return false;
  whole_header_ = frame.header;
  whole_poses_.clear();
  for (const std::unique_ptr<Chunk>& chunk : frame.chunks) {
    const size_t count = std::min(kChunkPoses, frame.node_count - whole_poses_.size());
    whole_poses_.insert(whole_poses_.end(), chunk->begin(),
                        chunk->begin() + static_cast<std::ptrdiff_t>(count));
  }
  return true;
}

}  // namespace fire3dv::stream
