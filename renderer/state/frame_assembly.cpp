#include "renderer/state/frame_assembly.h"

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
  oldest->header = part.header;
  oldest->poses.resize(part.node_count);
  oldest->have.assign(part.node_count, false);
  oldest->missing = part.node_count;
  return oldest;
}

FrameAssembly::Outcome FrameAssembly::add(const wire::PoseFrameView& part) {
  const uint64_t end = uint64_t{part.first_node} + part.poses.size();
  if (end > part.node_count || (part.poses.empty() && part.node_count != 0)) return Outcome::refused;
  OpenFrame* frame = frame_for(part);
  if (!frame) return Outcome::stale;
  // A frame is never put together from two steps, whatever the sender does with its sequence numbers.
  if (!(frame->header == part.header) || frame->have.size() != part.node_count) return Outcome::refused;

  uint32_t added = 0;
  for (size_t i = 0; i < part.poses.size(); ++i) {
    const size_t node = part.first_node + i;
    if (frame->have[node]) continue;
    frame->have[node] = true;
    frame->poses[node] = part.poses[i];
    ++added;
  }
  if (added == 0 && part.node_count != 0) return Outcome::stale;
  frame->missing -= added;
  if (frame->missing > 0) return Outcome::open;
  whole_ = frame;
  return Outcome::whole;
}

uint64_t FrameAssembly::close_up_to(uint64_t sequence) {
  uint64_t incomplete = 0;
  for (OpenFrame& frame : frames_) {
    if (frame.header.sequence == 0 || frame.header.sequence > sequence) continue;
    if (frame.header.sequence < sequence) ++incomplete;
    frame.header = {};
  }
  return incomplete;
}

void FrameAssembly::forget(uint64_t sequence) {
  for (OpenFrame& frame : frames_)
    if (frame.header.sequence == sequence) frame.header = {};
}

uint64_t FrameAssembly::take_given_up() {
  return std::exchange(given_up_, 0);
}

}  // namespace fire3dv::state
