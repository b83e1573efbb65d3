#include "protocol/record/frame_tally.h"

#include <algorithm>
#include <utility>

namespace fire3dv::record {

void FrameTally::begin() {
  for (Open& open : open_)
    if (std::exchange(open, {}).sequence != 0) ++given_up_;
  newest_ = 0;
}

bool FrameTally::take(const wire::PoseFrameView& frame) {
  const uint64_t sequence = frame.header.sequence;
  const bool is_part = frame.node_indices.empty() && frame.poses.size() < frame.node_count;
  if (is_part) ++counts_.parts;
  const auto known = std::ranges::find(open_, sequence, &Open::sequence);
  if (is_part && sequence != 0 && known != open_.end()) {
    known->covered += static_cast<uint32_t>(frame.poses.size());
    if (known->covered >= frame.node_count) *known = {};
    return false;
  }
  if (sequence <= newest_) {
    ++counts_.late;
    return false;
  }
  if (newest_ != 0) counts_.missing += sequence - newest_ - 1;
  newest_ = sequence;
  ++counts_.frames;
  if (is_part) {
    Open& oldest = *std::ranges::min_element(open_, {}, &Open::sequence);
    if (oldest.sequence != 0) ++given_up_;
    oldest = {sequence, static_cast<uint32_t>(frame.poses.size())};
  }
  return true;
}

uint64_t FrameTally::incomplete(bool is_over) const {
  const auto open = std::ranges::count_if(
      open_, [&](const Open& each) { return each.sequence != 0 && (is_over || each.sequence != newest_); });
  return given_up_ + static_cast<uint64_t>(open);
}

}  // namespace fire3dv::record
