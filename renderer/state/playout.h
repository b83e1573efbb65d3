// The frames of one stream from another machine, shown a little late and evenly in the simulator's time: what
// is to be seen at a time lies between two frames that have come by then. How late is chosen from how
// unevenly frames come, or fixed.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "protocol/wire/messages.h"
#include "renderer/state/pose_memory.h"
#include "renderer/state/sim_schedule.h"

namespace fire3dv::state {

class Playout {
 public:
  // Nothing: the delay follows the jitter. budget: of the peer whose frames these are; null: without limits.
  explicit Playout(std::optional<int64_t> fixed_delay_ns = {}, std::shared_ptr<PeerBudget> budget = nullptr)
      : fixed_delay_ns_(fixed_delay_ns), memory_(std::move(budget)) {}

  // A whole frame came. published_ns: on our clock, as far as it is known. False: it is older than what was
  // shown, was there already, or has no room in the budget.
  bool add(const wire::PoseFrameHeader& header, std::span<const wire::Affine3x4> poses, int64_t published_ns,
           int64_t received_ns);

  // The last frame was refused since the budget has no room for it.
  bool over_budget() const { return over_budget_; }

  // Other poses of a frame that is here already.
  void replace(uint64_t sequence, std::span<const wire::Affine3x4> poses);

  // What to show now. Nothing before the first frame. The header is that of the newest frame at or before the
  // moment shown, with the sim time of that moment.
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
    SimSchedule::Place place;
  };
  using Frames = std::deque<Frame>;
  std::optional<std::vector<wire::Affine3x4>> take_memory(size_t pose_count);
  void drop_oldest();
  SimSchedule::Place place_between(const Frame& earlier, Frame& later, const wire::PoseFrameHeader& header,
                                   int64_t published_ns) const;
  void measure(int64_t due_ns, int64_t received_ns);
  int64_t interval_ns() const;
  static double way(int64_t into_ns, int64_t span_ns);
  // True when that is something else than what was shown last.
  bool show(const Frame& earlier, const Frame& later, double t);

  std::optional<int64_t> fixed_delay_ns_;
  Frames frames_;  // by sequence; the first is the one at or before what was shown last
  SimSchedule schedule_;
  int64_t newest_published_ns_ = INT64_MIN / 2, newest_received_ns_ = 0;
  int64_t moment_ns_ = INT64_MIN;                    // shown last
  std::vector<std::vector<wire::Affine3x4>> spare_;  // memory of frames that are gone
  std::deque<int64_t> lateness_ns_;                  // of the last frames: received - due
  int64_t delay_ns_ = 0;
  std::vector<wire::Affine3x4> poses_;
  wire::PoseFrameHeader header_;
  uint64_t shown_later_ = 0;  // what poses_ and header_ were made of
  uint64_t shown_earlier_ = 0;
  double shown_t_ = 0;
  PoseMemory memory_;
  bool over_budget_ = false;
};

}  // namespace fire3dv::state
