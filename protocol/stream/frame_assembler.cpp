#include "protocol/stream/frame_assembler.h"

#include <algorithm>

namespace fire3dv::stream {

FrameAssembler::OpenFrame* FrameAssembler::frame_of(const wire::PoseFrameView& part) {
  if (OpenFrame* open = frames_.find(part.header.sequence)) return open;
  OpenFrame* frame = frames_.open(part.header.sequence);
  if (!frame) return nullptr;
  ++opened_;
  frame->header = part.header;
  frame->node_count = part.node_count;
  return frame;
}

// Allocates the chunks of poses [begin, end). Returns Outcome::open if the poses have room.
FrameAssembler::Outcome FrameAssembler::make_chunks(OpenFrame& frame, size_t begin, size_t end) {
  if (frame.chunks.size() * kChunkPoses < end) frame.chunks.resize((end + kChunkPoses - 1) / kChunkPoses);
  for (size_t i = begin / kChunkPoses; i * kChunkPoses < end; ++i) {
    if (frame.chunks[i]) continue;
    while (chunk_count_ >= kMaxChunks && make_room(frame, kMinOpenFrames)) continue;
    if (chunk_count_ >= kMaxChunks && frames_.size() > kMinOpenFrames) {  // this frame is the oldest
      frames_.give_up(frame);
      return Outcome::stale;
    }
    while (!memory_.take(kChunkPoses + 1))  // one more for the set of arrived poses
      if (!make_room(frame, 1)) return Outcome::over_budget;
    frame.chunks[i] = std::make_unique<Chunk>();
    ++chunk_count_;
  }
  return Outcome::open;
}

// Frees the memory of a free slot. If there is none, and more than `kept` frames are open, drops the oldest
// of those before `frame`. Returns false if there is nothing to free.
bool FrameAssembler::make_room(const OpenFrame& frame, size_t kept) {
  OpenFrame* const oldest = frames_.oldest_where([&](const OpenFrame& other) {
    return &other != &frame && std::ranges::any_of(other.chunks, [](const auto& chunk) { return !!chunk; });
  });
  if (!oldest || oldest->sequence > frame.sequence) return false;
  if (oldest->sequence != 0) {
    if (frames_.size() <= kept) return false;
    frames_.give_up(*oldest);
  }
  free_chunks(*oldest);
  return true;
}

void FrameAssembler::free_chunks(OpenFrame& frame) {
  const auto count = static_cast<size_t>(
      std::ranges::count_if(frame.chunks, [](const auto& chunk) { return chunk != nullptr; }));
  frame.chunks.clear();
  frame.arrived = {};
  chunk_count_ -= count;
  memory_.give_back(count * (kChunkPoses + 1));
}

FrameAssembler::Outcome FrameAssembler::add(const wire::PoseFrameView& part) {
  const uint64_t end = uint64_t{part.first_node} + part.poses.size();
  if (end > part.node_count || (part.poses.empty() && part.node_count != 0)) return Outcome::refused;
  OpenFrame* frame = frame_of(part);
  if (!frame) return Outcome::stale;
  if (!(frame->header == part.header) || frame->node_count != part.node_count) return Outcome::refused;
  if (const Outcome room = make_chunks(*frame, part.first_node, end); room != Outcome::open) return room;

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
  while (!memory_.reserve(whole_poses_, frame.node_count))
    if (!make_room(frame, 1)) return false;
  ++completed_;
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
