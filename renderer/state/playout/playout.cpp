#include "renderer/state/playout/playout.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "renderer/state/playout/interpolate.h"

namespace fire3dv::state {
namespace {

constexpr size_t kMaxFrames = 256;
constexpr size_t kMaxPoses = size_t{4} << 20;  // 192 MiB per stream
constexpr size_t kLatenessWindow = 256;
constexpr int64_t kMillisecondNs = 1'000'000;
constexpr int64_t kMaxDelayNs = 1000 * kMillisecondNs;
constexpr int64_t kMaxClockErrorNs = 60'000 * kMillisecondNs;
constexpr int64_t kMarginNs = 2 * kMillisecondNs;
constexpr int64_t kMaxExtrapolationNs = 100 * kMillisecondNs;

// Frame times are untrusted: the subtraction wraps instead of overflowing.
double sim_step_ns(const wire::PoseFrameHeader& from, const wire::PoseFrameHeader& to) {
  return static_cast<double>(
      static_cast<int64_t>(static_cast<uint64_t>(to.sim_time_ns) - static_cast<uint64_t>(from.sim_time_ns)));
}

bool jumps(const wire::PoseFrameHeader& into) {
  return (into.flags & wire::kFrameDiscontinuity) != 0;
}

}  // namespace

bool Playout::add(const wire::PoseFrameHeader& header, std::span<const wire::Affine3x4> poses,
                  int64_t published_ns, int64_t received_ns) {
  // A peer's clock is untrusted. Only order and distance of frames matter, so the offset may be clamped.
  published_ns = std::clamp(published_ns, received_ns - kMaxClockErrorNs, received_ns + kMaxClockErrorNs);
  const auto later = std::find_if(frames_.begin(), frames_.end(), [&](const Frame& frame) {
    return frame.header.sequence >= header.sequence;
  });
  if (later != frames_.end() && later->header.sequence == header.sequence) return false;
  // The playout has passed this frame: inserting it would put it before the frame that is shown.
  if (later == frames_.begin() && !frames_.empty()) return false;
  std::optional<std::vector<wire::Affine3x4>> memory = take_memory(poses.size());
  over_budget_ = !memory;
  if (over_budget_) return false;
  Frame frame;
  frame.header = header;
  frame.poses = std::move(*memory);
  bool queued = false;
  if (later == frames_.end()) {
    // Publish times that go backwards are ignored: frames are shown in sequence order.
    const int64_t before_ns =
        std::exchange(newest_published_ns_, std::max(newest_published_ns_, published_ns));
    queued = !frames_.empty() && received_ns - newest_received_ns_ < (newest_published_ns_ - before_ns) / 4;
    newest_received_ns_ = received_ns;
    frame.place = schedule_.next(header.sim_time_ns, newest_published_ns_, jumps(header));
  } else {
    frame.place = place_between(*std::prev(later), *later, header, published_ns);
  }
  // Frames that queued behind one delayed frame count as one late arrival, not as several.
  if (!queued) measure(frame.place.due_ns, received_ns);
  frame.poses.assign(poses.begin(), poses.end());
  frames_.insert(later, std::move(frame));
  while (frames_.size() > kMaxFrames || (frames_.size() > 2 && frames_.size() * poses.size() > kMaxPoses)) {
    drop_oldest();
  }
  return true;
}

void Playout::drop_oldest() {
  spare_.push_back(std::move(frames_.front().poses));
  frames_.pop_front();
}

// Returns a pose vector with capacity for one more frame; nullopt if the budget has no room.
std::optional<std::vector<wire::Affine3x4>> Playout::take_memory(size_t pose_count) {
  std::vector<wire::Affine3x4> poses;
  if (!spare_.empty()) {
    poses = std::move(spare_.back());
    spare_.pop_back();
  }
  if (memory_.reserve(poses_, pose_count) && memory_.reserve(poses, pose_count)) return poses;
  memory_.give_back(poses.capacity());
  return std::nullopt;
}

// Schedules a frame that arrived out of order: its due time is interpolated between its neighbours.
PlayoutSchedule::Place Playout::place_between(const Frame& earlier, Frame& later,
                                              const wire::PoseFrameHeader& header,
                                              int64_t published_ns) const {
  const double whole = sim_step_ns(earlier.header, later.header);
  const double part = sim_step_ns(earlier.header, header);
  const int64_t begin_ns = earlier.place.due_ns, end_ns = later.place.due_ns;
  const bool even = part >= 0 && part <= whole && whole > 0 && !jumps(later.header) && !jumps(header);
  const int64_t due_ns =
      even ? begin_ns + static_cast<int64_t>(static_cast<double>(end_ns - begin_ns) * (part / whole))
           : std::clamp(published_ns, begin_ns, end_ns);
  const int64_t from_ns = jumps(header) ? due_ns : std::min(due_ns, later.place.from_ns);
  later.place.from_ns = std::max(later.place.from_ns, due_ns);
  return {std::max(from_ns, begin_ns), due_ns};
}

void Playout::replace(uint64_t sequence, std::span<const wire::Affine3x4> poses) {
  const auto frame = std::find_if(frames_.begin(), frames_.end(),
                                  [&](const Frame& f) { return f.header.sequence == sequence; });
  if (frame == frames_.end()) return;
  frame->poses.assign(poses.begin(), poses.end());
  shown_later_ = shown_earlier_ = 0;  // invalidate the cached interpolation
}

// Updates the delay to the 98th percentile of lateness plus one frame interval, so that the next frame is
// there in time. The delay rises immediately, else motion would stop. It falls slowly, since each change is
// visible as a change of speed.
void Playout::measure(int64_t due_ns, int64_t received_ns) {
  if (received_ns - due_ns > kMaxDelayNs) return;  // left over from an outage; no delay would be enough
  lateness_ns_.push_back(received_ns - due_ns);
  if (lateness_ns_.size() > kLatenessWindow) lateness_ns_.pop_front();
  std::vector<int64_t> sorted(lateness_ns_.begin(), lateness_ns_.end());
  const size_t at = std::min(sorted.size() - 1, sorted.size() * 98 / 100);
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(at), sorted.end());
  const int64_t wanted = std::clamp<int64_t>(sorted[at] + interval_ns() + kMarginNs, 0, kMaxDelayNs);
  delay_ns_ = wanted > delay_ns_ ? wanted : delay_ns_ - (delay_ns_ - wanted) / 32;
}

// Mean interval of the buffered frames. Few frames suffice: the value is only added to the delay.
int64_t Playout::interval_ns() const {
  if (frames_.size() < 2) return 0;
  const int64_t span = frames_.back().place.due_ns - frames_.front().place.due_ns;
  return span / static_cast<int64_t>(frames_.back().header.sequence - frames_.front().header.sequence);
}

std::optional<Playout::Shown> Playout::at(int64_t now_ns) {
  if (frames_.empty()) return {};
  // A rising delay stops motion; it never moves it backwards.
  moment_ns_ = std::max(moment_ns_, now_ns - delay_ns());
  while (frames_.size() > 2 && frames_[1].place.due_ns <= moment_ns_) {
    drop_oldest();
  }
  for (; spare_.size() > 8; spare_.pop_back()) memory_.give_back(spare_.back().capacity());
  const Frame& earlier = frames_.front();
  const Frame& later = frames_.size() > 1 ? frames_[1] : earlier;
  const auto [from_ns, due_ns] = later.place;
  const bool alone = &later == &earlier;
  const bool changed = show(earlier, later, alone ? 0 : way(moment_ns_ - from_ns, due_ns - from_ns));
  return Shown{header_, poses_, changed};
}

// Interpolation factor between two frames; 1 is the later frame. If the next frame is late, motion is
// extrapolated for at most kMaxExtrapolationNs, then returns to the last frame. A simulator that pauses is
// therefore shown where it stands.
double Playout::way(int64_t into_ns, int64_t span_ns) {
  if (into_ns <= 0) return span_ns <= 0 && into_ns == 0 ? 1 : 0;
  if (span_ns <= 0) return 1;  // a jump is not interpolated: hold the earlier frame
  const int64_t most = std::min(2 * span_ns, kMaxExtrapolationNs);
  const int64_t over = into_ns - span_ns;
  if (over > 2 * most) return 1;
  return static_cast<double>(over <= most ? into_ns : span_ns + 2 * most - over) /
         static_cast<double>(span_ns);
}

bool Playout::show(const Frame& earlier, const Frame& later, double t) {
  if (earlier.header.sequence == shown_earlier_ && later.header.sequence == shown_later_ && t == shown_t_)
    return false;
  shown_earlier_ = earlier.header.sequence;
  shown_later_ = later.header.sequence;
  shown_t_ = t;
  header_ = t >= 1 ? later.header : earlier.header;
  const auto moved =
      static_cast<int64_t>(std::clamp(sim_step_ns(earlier.header, later.header) * t, -9e18, 9e18));
  header_.sim_time_ns =
      static_cast<int64_t>(static_cast<uint64_t>(earlier.header.sim_time_ns) + static_cast<uint64_t>(moved));
  poses_.resize(later.poses.size());
  const bool comparable = earlier.poses.size() == later.poses.size();
  for (size_t i = 0; i < poses_.size(); ++i)
    poses_[i] = comparable ? interpolate(earlier.poses[i], later.poses[i], t) : later.poses[i];
  return true;
}

}  // namespace fire3dv::state
