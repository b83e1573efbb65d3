// Whole frames that came before the scene edits that they belong to. Two are kept: the one that waits for the
// lowest version, which is the next that can be shown, and the newest. With the newest alone, a stream whose
// edits come faster than its link carries them would never be shown.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "protocol/wire/messages.h"
#include "renderer/state/pose_memory.h"

namespace fire3dv::state {

struct HeldFrame {
  wire::PoseFrameHeader header;
  std::vector<wire::Affine3x4> poses;
  int64_t published_ns = 0;
  int64_t received_ns = 0;
};

class HeldFrames {
 public:
  HeldFrames() = default;
  // Null: without limits.
  explicit HeldFrames(std::shared_ptr<PeerBudget> budget) : memory_(std::move(budget)) {}

  bool empty() const { return count_ == 0; }
  const HeldFrame& newest() const { return frames_[count_ - 1]; }

  enum class Outcome {
    added,
    replaced,     // another frame was given up for it
    over_budget,  // the peer's budget has no room for it: not held
  };
  // `header` is newer than all that are held.
  Outcome hold(const wire::PoseFrameHeader& header, std::span<const wire::Affine3x4> poses,
               int64_t published_ns, int64_t received_ns) {
    // A newer frame that waits for the same edits takes the older one's place.
    const bool replaces =
        count_ == frames_.size() || (count_ == 1 && header.scene_version <= frames_[0].header.scene_version);
    HeldFrame& frame = frames_[replaces ? count_ - 1 : count_];
    if (!memory_.reserve(frame.poses, poses.size())) return Outcome::over_budget;
    if (!replaces) ++count_;
    frame.header = header;
    frame.poses.assign(poses.begin(), poses.end());
    frame.published_ns = published_ns;
    frame.received_ns = received_ns;
    return replaces ? Outcome::replaced : Outcome::added;
  }

  // The oldest, when it waits for no more than this version; valid until the next call.
  const HeldFrame* release(uint64_t applied_version) {
    if (count_ == 0 || frames_[0].header.scene_version > applied_version) return nullptr;
    std::swap(released_, frames_[0]);
    if (--count_ == 1) std::swap(frames_[0], frames_[1]);
    return &released_;
  }

  // Frames up to this sequence need not wait any longer; returns how many there were.
  uint64_t drop_up_to(uint64_t sequence) {
    uint64_t dropped = 0;
    while (count_ != 0 && frames_[0].header.sequence <= sequence) {
      if (--count_ == 1) std::swap(frames_[0], frames_[1]);
      ++dropped;
    }
    return dropped;
  }

 private:
  std::array<HeldFrame, 2> frames_;  // by sequence
  size_t count_ = 0;
  HeldFrame released_;
  PoseMemory memory_;
};

}  // namespace fire3dv::state
