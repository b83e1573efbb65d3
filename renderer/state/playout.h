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

#include "protocol/stream/frame_assembler.h"
#include "protocol/wire/messages.h"

namespace fire3dv::state {

// Interpolation of two poses: slerp for the rotation, linear for translation and scale. Matrices with shear,
// singular matrices, and pairs of which one is mirrored are interpolated element by element. Returns exactly
// `a` at t 0 and `b` at t 1; t above 1 extrapolates.
wire::Affine3x4 interpolate(const wire::Affine3x4& a, const wire::Affine3x4& b, double t);

// Playout schedule of one stream: due times of its frames on the publish clock. Due times are evenly spaced
// in simulator time along a line fitted to publish times. Bursts and single delays of publishing are
// smoothed, for simulators faster and slower than real time.
class PlayoutSchedule {
 public:
  struct Slot {
    int64_t from_ns = 0;  // start of the motion from the previous frame
    int64_t due_ns = 0;   // end of the motion; equal to from_ns for a jump
  };

  // Schedules the next frame, in sequence order; published_ns must not decrease. jump: bodies or time jumped.
  // A simulator time that goes back is a jump in any case.
  Slot next(int64_t sim_ns, int64_t published_ns, bool jump);

 private:
  Slot begin_at(int64_t due_ns);
  double measure(double step_ns, double expected_ns, double error_ns);  // returns the position gain

  bool begun_ = false;
  bool stood_still_ = false;  // at the previous frame
  int64_t sim_ns_ = 0, published_ns_ = 0, due_ns_ = 0;
  double ns_per_sim_ns_ = 0;  // valid if measured_ > 0
  uint32_t measured_ = 0;     // number of measured steps
};

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
    PlayoutSchedule::Slot slot;
  };
  using Frames = std::deque<Frame>;
  std::optional<std::vector<wire::Affine3x4>> take_memory(size_t pose_count);
  void drop_oldest();
  PlayoutSchedule::Slot slot_between(const Frame& earlier, Frame& later, const wire::PoseFrameHeader& header,
                                     int64_t published_ns) const;
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
