// Playout buffer of one remote stream: shows frames with a delay, evenly in simulator time. Poses are
// interpolated between the two frames around the moment shown. The delay is fixed or follows the jitter.
// Times are in nanoseconds; memory is charged to the peer's budget. Not thread-safe.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "protocol/stream/pose_memory.h"
#include "protocol/wire/messages.h"
#include "renderer/state/playout/playout_schedule.h"

namespace fire3dv::state {

class Playout {
 public:
  // fixed_delay_ns nullopt: the delay follows the jitter. budget: that of the publishing peer; null: no
  // limits.
  explicit Playout(std::optional<int64_t> fixed_delay_ns = {}, std::shared_ptr<PeerBudget> budget = nullptr)
      : fixed_delay_ns_(fixed_delay_ns), memory_(std::move(budget)) {}

  // Adds a whole frame. published_ns: publish time on the local clock, as estimated. Returns false if the
  // frame is older than the one shown, a duplicate, or over budget.
  bool add(const wire::PoseFrameHeader& header, std::span<const wire::Affine3x4> poses, int64_t published_ns,
           int64_t received_ns);

  // True if the budget refused the last frame.
  bool over_budget() const { return over_budget_; }

  // Replaces the poses of a buffered frame.
  void replace(uint64_t sequence, std::span<const wire::Affine3x4> poses);

  // Pose frame at a moment. The header is that of the newest frame at or before it, with the interpolated
  // simulator time. nullopt before the first frame.
  struct Shown {
    wire::PoseFrameHeader header;
    std::span<const wire::Affine3x4> poses;  // valid until the next call
    bool changed = false;                    // since the last call
  };
  std::optional<Shown> at(int64_t now_ns);

  int64_t delay_ns() const { return fixed_delay_ns_.value_or(delay_ns_); }
  uint64_t newest_sequence() const { return frames_.empty() ? 0 : frames_.back().header.sequence; }

 private:
  struct Frame {
    wire::PoseFrameHeader header;
    std::vector<wire::Affine3x4> poses;
    PlayoutSchedule::Place place;
  };
  using Frames = std::deque<Frame>;
  std::optional<std::vector<wire::Affine3x4>> take_memory(size_t pose_count);
  void drop_oldest();
  PlayoutSchedule::Place place_between(const Frame& earlier, Frame& later,
                                       const wire::PoseFrameHeader& header, int64_t published_ns) const;
  void measure(int64_t due_ns, int64_t received_ns);
  int64_t interval_ns() const;
  static double way(int64_t into_ns, int64_t span_ns);
  // Returns true if the poses differ from those shown last.
  bool show(const Frame& earlier, const Frame& later, double t);

  std::optional<int64_t> fixed_delay_ns_;
  Frames frames_;  // sorted by sequence; the first one is at or before the moment shown
  PlayoutSchedule schedule_;
  int64_t newest_published_ns_ = INT64_MIN / 2, newest_received_ns_ = 0;
  int64_t moment_ns_ = INT64_MIN;                    // moment of the last at()
  std::vector<std::vector<wire::Affine3x4>> spare_;  // recycled memory of dropped frames
  std::deque<int64_t> lateness_ns_;                  // receive time minus due time, of the last frames
  int64_t delay_ns_ = 0;
  std::vector<wire::Affine3x4> poses_;
  wire::PoseFrameHeader header_;
  uint64_t shown_later_ = 0;  // cache key of poses_ and header_, with the next two
  uint64_t shown_earlier_ = 0;
  double shown_t_ = 0;
  stream::PoseMemory memory_;
  bool over_budget_ = false;
};

}  // namespace fire3dv::state
