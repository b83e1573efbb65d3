#include "protocol/record/frame_counter.h"

namespace fire3dv::record {
namespace {
constexpr uint64_t kSeenFrames = 64;  // bits of seen_
}  // namespace

void FrameCounter::begin() {
  given_up_ += open_.size();
  open_.close_up_to(UINT64_MAX);
  newest_ = first_ = seen_ = 0;
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
    // Jitter lets parts of a frame overtake all parts of the frame before.
    const uint64_t age = newest_ - sequence;
    if (!is_part || sequence < first_ || age >= kSeenFrames || (seen_ >> age & 1) != 0 || !open(frame)) {
      ++counts_.late;
      return false;
    }
    seen_ |= uint64_t{1} << age;
    --counts_.missing;
    ++counts_.frames;
    return true;
  }
  if (newest_ != 0)
    counts_.missing += sequence - newest_ - 1;
  else
    first_ = sequence;
  seen_ = sequence - newest_ < kSeenFrames ? seen_ << (sequence - newest_) : 0;
  seen_ |= 1;
  newest_ = sequence;
  ++counts_.frames;
  if (is_part) open(frame);
  return true;
}

// Opens the frame of its first part. Returns false if all open frames are newer.
bool FrameCounter::open(const wire::PoseFrameView& part) {
  OpenFrame* const opened = open_.open(part.header.sequence);
  given_up_ += open_.take_given_up();
  if (opened == nullptr) return false;
  opened->header = part.header;
  opened->node_count = part.node_count;
  add_part(*opened, part);
  return true;
}

uint64_t FrameCounter::incomplete(bool is_over) const {
  const bool newest_may_follow = !is_over && open_.find(newest_) != nullptr;
  return given_up_ + open_.size() - (newest_may_follow ? 1 : 0);
}

}  // namespace fire3dv::record
