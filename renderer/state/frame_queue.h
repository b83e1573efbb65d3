// Queue of whole pose frames that wait for their scene edits. It holds two frames: the one with the lowest
// scene version, and the newest. With the newest alone, a stream would never be shown if its edits came
// faster than its link carries them. Poses are charged to the peer's budget. Not thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "protocol/stream/pose_memory.h"
#include "protocol/wire/messages.h"

namespace fire3dv::state {

struct QueuedFrame {
  wire::PoseFrameHeader header;
  std::vector<wire::Affine3x4> poses;
  int64_t published_ns = 0;
  int64_t received_ns = 0;
};

class FrameQueue {
 public:
  FrameQueue() = default;
  // budget null: no limits.
  explicit FrameQueue(std::shared_ptr<PeerBudget> budget) : memory_(std::move(budget)) {}

  bool empty() const { return count_ == 0; }
  const QueuedFrame& newest() const { return frames_[count_ - 1]; }

  enum class Outcome {
    added,
    replaced,     // replaced a queued frame
    over_budget,  // the peer's budget has no room; the frame is not queued
  };
  // Precondition: `header` is newer than all queued frames.
  Outcome push(const wire::PoseFrameHeader& header, std::span<const wire::Affine3x4> poses,
               int64_t published_ns, int64_t received_ns) {
    // A newer frame with the same scene version replaces the older one.
    const bool replaces =
        count_ == frames_.size() || (count_ == 1 && header.scene_version <= frames_[0].header.scene_version);
    QueuedFrame& frame = frames_[replaces ? count_ - 1 : count_];
    if (!memory_.reserve(frame.poses, poses.size())) return Outcome::over_budget;
    if (!replaces) ++count_;
    frame.header = header;
    frame.poses.assign(poses.begin(), poses.end());
    frame.published_ns = published_ns;
    frame.received_ns = received_ns;
    return replaces ? Outcome::replaced : Outcome::added;
  }

  // Removes and returns the oldest frame if its scene version is applied, else null. Valid until the next
  // call.
  const QueuedFrame* release(uint64_t applied_version) {
    if (count_ == 0 || frames_[0].header.scene_version > applied_version) return nullptr;
    std::swap(released_, frames_[0]);
    if (--count_ == 1) std::swap(frames_[0], frames_[1]);
    return &released_;
  }

  // Drops frames up to this sequence; returns their number.
  uint64_t drop_up_to(uint64_t sequence) {
    uint64_t dropped = 0;
    while (count_ != 0 && frames_[0].header.sequence <= sequence) {
      if (--count_ == 1) std::swap(frames_[0], frames_[1]);
      ++dropped;
    }
    return dropped;
  }

 private:
  std::array<QueuedFrame, 2> frames_;  // sorted by sequence
  size_t count_ = 0;
  QueuedFrame released_;
  stream::PoseMemory memory_;
};

}  // namespace fire3dv::state
