// Scene edits of one stream on their way to the scene, and the pose frames that wait for them. Both are
// charged to the peer's budget. Not thread-safe.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/peer_budget.h"
#include "protocol/stream/frame_assembler.h"
#include "protocol/wire/messages.h"
#include "protocol/wire/scene_edit.h"

namespace fire3dv::state {

// The newest edit of each key, until take(). Keys and values are charged. The applied version decides which
// pose frames may be shown.
class StreamEdits {
 public:
  enum class Outcome {
    accepted,
    stale,    // not newer than the received ones
    refused,  // over the budget. Its version counts as received: frames must not wait for it forever
  };

  StreamEdits() = default;
  // budget null: no limits.
  explicit StreamEdits(std::shared_ptr<PeerBudget> budget);

  Outcome add(wire::SceneEdit&& edit);
  // An edit of a later minor version: without effect, but applied.
  Outcome skip(uint64_t version);

  // Limit and message of the last refused edit.
  Resource refused_resource() const { return refused_resource_; }
  const std::string& refusal() const { return refusal_; }

  // All edits up to this version are in effect, or will be before the next image.
  uint64_t applied() const {
    return loading_.empty() ? received_ : std::min(received_, *loading_.begin() - 1);
  }

  // Edits by version, without those that a newer one of their key replaced.
  struct Batch {
    std::vector<wire::SceneEdit> edits;
    std::vector<BudgetCharge> charges;  // one per edit; held while its value is in force
  };
  // Returns and clears the edits since the last call.
  Batch take();
  bool has_new() const { return !pending_.empty(); }
  // True if take() has returned an edit.
  bool has_applied() const { return has_applied_; }

  // From now on added nodes and vertices load on another thread: they are in effect after finish() of their
  // version.
  void load_assets_asynchronously() { loads_asynchronously_ = true; }
  void finish(uint64_t version) { loading_.erase(version); }

 private:
  using Key = std::pair<std::string, wire::Property>;
  struct Pending {
    wire::SceneEdit edit;
    BudgetCharge charge;
  };
  Outcome refuse(Resource resource, std::string message);
  Result<void> charge_key(const Key& key);
  void drop_key(const Key& key);

  std::shared_ptr<PeerBudget> budget_;
  std::set<Key> keys_;  // pending or in force
  BudgetCharge key_count_, key_bytes_;
  std::map<Key, Pending> pending_;
  uint64_t received_ = 0;
  bool loads_asynchronously_ = false;
  std::set<uint64_t> loading_;
  bool has_applied_ = false;
  Resource refused_resource_ = Resource::edits;
  std::string refusal_;
};

struct QueuedFrame {
  wire::PoseFrameHeader header;
  std::vector<wire::Affine3x4> poses;
  int64_t published_ns = 0;
  int64_t received_ns = 0;
};

// Queue of whole pose frames that wait for their scene edits. It holds two frames: the one with the lowest
// scene version, and the newest. With the newest alone, a stream would never be shown if its edits came
// faster than its link carries them.
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
