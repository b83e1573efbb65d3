#include "protocol/transport/udp/udp_window.h"

#include <algorithm>

namespace fire3dv::transport::udp {

bool ReplayWindow::is_new(uint64_t counter) const {
  if (counter == 0) return false;
  if (counter > newest_) return true;
  if (newest_ - counter >= kSpan) return false;
  return (seen_[counter % kSpan / 64] >> (counter % 64) & 1) == 0;
}

void ReplayWindow::mark(uint64_t counter) {
  if (counter > newest_) {
    // Forget what the window moves over.
    const uint64_t steps = std::min(counter - newest_, kSpan);
    for (uint64_t i = 1; i <= steps; ++i) {
      const uint64_t cleared = (counter - steps + i) % kSpan;
      seen_[cleared / 64] &= ~(uint64_t{1} << (cleared % 64));
    }
    newest_ = counter;
  }
  seen_[counter % kSpan / 64] |= uint64_t{1} << (counter % 64);
}

FrameTracker::Outcome FrameTracker::part(uint64_t frame, uint16_t part, bool last) {
  if (frame == newest_whole_) return Outcome::repeated;
  if (frame < newest_whole_) return Outcome::superseded;
  auto building =
      std::find_if(building_.begin(), building_.end(), [&](const Building& b) { return b.frame == frame; });
  if (building == building_.end()) {
    if (building_.size() == kMostBuilding) {
      const auto oldest = std::min_element(building_.begin(), building_.end(),
                                           [](const auto& a, const auto& b) { return a.frame < b.frame; });
      if (oldest->frame > frame) return Outcome::superseded;
      building_.erase(oldest);
    }
    building_.push_back({frame, 0, 0, {}});
    building = building_.end() - 1;
  }
  if (building->came.size() <= part / 64u) building->came.resize(part / 64u + 1);
  uint64_t& word = building->came[part / 64u];
  const uint64_t bit = uint64_t{1} << (part % 64u);
  if ((word & bit) != 0) return Outcome::repeated;
  word |= bit;
  ++building->count;
  if (last) building->total = uint32_t{part} + 1;
  if (building->total == 0 || building->count < building->total) return Outcome::part;
  newest_whole_ = frame;
  std::erase_if(building_, [&](const Building& b) { return b.frame <= frame; });
  return Outcome::whole;
}

}  // namespace fire3dv::transport::udp
