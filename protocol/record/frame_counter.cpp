#include "protocol/record/frame_counter.h"

namespace fire3dv::record {

void FrameCounter::begin() {
  given_up_ += open_.size();
  open_.close_up_to(UINT64_MAX);
  newest_ = 0;
}

// Returns false if the part adds no pose to the frame.
bool FrameCounter::add_part(OpenFrame& frame, const wire::PoseFrameView& part) {
  if (!(frame.header == part.header) || frame.node_count != part.node_count) return false;
  const auto count = static_cast<uint32_t>(part.poses.size());
  if (frame.arrived.insert_range(part.first_node, count) == 0) return false;
  if (frame.arrived.size() == part.node_count) frame.clear();
  return true;
}

bool FrameCounter::take(const wire::PoseFrameView& frame) {
  const uint64_t sequence = frame.header.sequence;
  const bool is_part = frame.node_indices.empty() && frame.poses.size() < frame.node_count;
  if (is_part) ++counts_.parts;
  OpenFrame* known = is_part ? open_.find(sequence) : nullptr;
  if (known != nullptr) {
    if (!add_part(*known, frame)) ++counts_.late;
    return false;
  }
  if (sequence <= newest_) {
    ++counts_.late;
    return false;
  }
  if (newest_ != 0) counts_.missing += sequence - newest_ - 1;
  newest_ = sequence;
  ++counts_.frames;
  if (!is_part) return true;
  OpenFrame& opened = *open_.open(sequence);  // never null: this sequence is the newest
  given_up_ += open_.take_given_up();
  opened.header = frame.header;
  opened.node_count = frame.node_count;
  add_part(opened, frame);
  return true;
}

uint64_t FrameCounter::incomplete(bool is_over) const {
  const bool newest_may_follow = !is_over && open_.find(newest_) != nullptr;
  return given_up_ + open_.size() - (newest_may_follow ? 1 : 0);
}

}  // namespace fire3dv::record
