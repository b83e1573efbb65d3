#include "renderer/state/playout.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <utility>

namespace fire3dv::state {
namespace {

struct Parts {
  glm::dquat rotation;
  glm::dvec3 scale;  // x is negative for a mirrored matrix
};

// Splits a matrix into rotation and scale. Fails if its columns are not orthogonal within float precision.
std::optional<Parts> split(const wire::Affine3x4& affine) {
  glm::dmat3 matrix;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      matrix[column][row] = static_cast<double>(affine.m[static_cast<size_t>(row * 4 + column)]);
  constexpr double kLeast = 1e-12, kSkew = 1e-4;
  Parts parts;
  for (int column = 0; column < 3; ++column) {
    parts.scale[column] = glm::length(matrix[column]);
    if (!(parts.scale[column] > kLeast)) return {};
    matrix[column] /= parts.scale[column];
  }
  if (std::abs(glm::dot(matrix[0], matrix[1])) > kSkew || std::abs(glm::dot(matrix[1], matrix[2])) > kSkew ||
      std::abs(glm::dot(matrix[2], matrix[0])) > kSkew)
    return {};
  if (glm::determinant(matrix) < 0) {
    matrix[0] = -matrix[0];
    parts.scale.x = -parts.scale.x;
  }
  parts.rotation = glm::normalize(glm::quat_cast(matrix));
  return parts;
}

// Spherical interpolation that also extrapolates (t > 1); glm::slerp does not guarantee that.
glm::dquat turn(const glm::dquat& from, const glm::dquat& to, double t) {
  glm::dquat difference = glm::conjugate(from) * to;
  if (difference.w < 0) difference = -difference;  // the shorter arc
  const glm::dvec3 axis(difference.x, difference.y, difference.z);
  const double sine = glm::length(axis);
  if (sine < 1e-12) return from;
  const double half_angle = std::atan2(sine, difference.w) * t;
  return from * glm::dquat(std::cos(half_angle), axis * (std::sin(half_angle) / sine));
}

float mix(float a, float b, double t) {
  return static_cast<float>(static_cast<double>(a) + (static_cast<double>(b) - static_cast<double>(a)) * t);
}

}  // namespace

wire::Affine3x4 interpolate(const wire::Affine3x4& a, const wire::Affine3x4& b, double t) {
  if (t == 0 || a == b) return a;
  if (t == 1) return b;
  wire::Affine3x4 result;
  for (size_t i = 0; i < 12; ++i) result.m[i] = mix(a.m[i], b.m[i], t);
  const auto first = split(a), second = split(b);
  if (!first || !second || (first->scale.x < 0) != (second->scale.x < 0)) return result;
  const glm::dmat3 rotation = glm::mat3_cast(turn(first->rotation, second->rotation, t));
  const glm::dvec3 scale = first->scale + (second->scale - first->scale) * t;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      result.m[static_cast<size_t>(row * 4 + column)] =
          static_cast<float>(rotation[column][row] * scale[column]);
  return result;
}

namespace {

constexpr double kFollowNs = 300e6;  // time constant of the filter
constexpr double kMaxOffNs = 50e6;   // maximum distance of due time and publish time
constexpr double kStandstillNs = 250e6;
constexpr uint32_t kMaxMeasured = 1000;  // then the filter is in steady state

// Times of a peer are untrusted: the subtraction wraps instead of overflowing.
int64_t difference(int64_t a, int64_t b) {
  return static_cast<int64_t>(static_cast<uint64_t>(a) - static_cast<uint64_t>(b));
}

}  // namespace

PlayoutSchedule::Slot PlayoutSchedule::next(int64_t sim_ns, int64_t published_ns, bool jump) {
  const auto step_ns = static_cast<double>(difference(sim_ns, sim_ns_));
  const auto gap_ns = static_cast<double>(published_ns - published_ns_);
  const bool first = !begun_;
  begun_ = true;
  sim_ns_ = sim_ns;
  published_ns_ = published_ns;
  if (first || jump || step_ns < 0) return begin_at(std::max(published_ns, due_ns_));
  const int64_t from_ns = due_ns_;
  if (step_ns == 0) {  // the simulator is paused; poses may still change
    due_ns_ = std::max(due_ns_, published_ns);
    return {from_ns, due_ns_};
  }

  const double expected_ns = measured_ > 0 ? ns_per_sim_ns_ * step_ns : gap_ns;
  const double error_ns = static_cast<double>(published_ns - due_ns_) - expected_ns;
  if (error_ns > kStandstillNs) {
    // The simulator resumes after a standstill: bodies wait, then move within the last interval. Two
    // standstills in a row are a new rate, not a pause.
    if (stood_still_) measured_ = 0;
    stood_still_ = true;
    due_ns_ = published_ns;
    const double way_ns = std::min(expected_ns, gap_ns);
    return {std::max(from_ns, due_ns_ - static_cast<int64_t>(way_ns)), due_ns_};
  }
  stood_still_ = false;
  const double position_gain = measure(step_ns, expected_ns, error_ns);
  const double off_ns = (position_gain - 1) * error_ns;  // due time minus publish time
  if (std::abs(off_ns) > kMaxOffNs) {                    // new rate: restart the line
    measured_ = 1;
    ns_per_sim_ns_ = gap_ns / step_ns;
  }
  due_ns_ = std::max(from_ns, published_ns + static_cast<int64_t>(std::clamp(off_ns, -kMaxOffNs, kMaxOffNs)));
  return {from_ns, due_ns_};
}

PlayoutSchedule::Slot PlayoutSchedule::begin_at(int64_t due_ns) {
  due_ns_ = due_ns;
  stood_still_ = false;
  return {due_ns, due_ns};
}

// Line fit of publish time over simulator time with exponential forgetting. The gains are those of a
// least-squares fit first, then of a critically damped filter. They depend on the expected interval, so that
// frames of a burst have their usual weight. Returns the position gain.
double PlayoutSchedule::measure(double step_ns, double expected_ns, double error_ns) {
  measured_ = std::min(measured_ + 1, kMaxMeasured);
  const double k = measured_;
  const double steady = 1 - std::exp(-expected_ns / kFollowNs);
  const double pace_gain = std::max(steady * steady / (2 - steady), 6 / ((k + 1) * (k + 2)));
  if (measured_ == 1) ns_per_sim_ns_ = expected_ns / step_ns;
  ns_per_sim_ns_ = std::max(0.0, ns_per_sim_ns_ + pace_gain * error_ns / step_ns);
  return std::max(steady, (4 * k + 2) / ((k + 1) * (k + 2)));
}

namespace {

constexpr size_t kMaxFrames = 256;
constexpr size_t kMaxPoses = size_t{4} << 20;  // 192 MiB per stream
constexpr size_t kLatenessWindow = 256;
constexpr int64_t kMillisecondNs = 1'000'000;
constexpr int64_t kMaxDelayNs = 1000 * kMillisecondNs;
constexpr int64_t kMaxClockErrorNs = 60'000 * kMillisecondNs;
constexpr int64_t kMarginNs = 2 * kMillisecondNs;
constexpr int64_t kMaxExtrapolationNs = 100 * kMillisecondNs;

double sim_step_ns(const wire::PoseFrameHeader& from, const wire::PoseFrameHeader& to) {
  return static_cast<double>(difference(to.sim_time_ns, from.sim_time_ns));
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
    frame.slot = schedule_.next(header.sim_time_ns, newest_published_ns_, jumps(header));
  } else {
    frame.slot = slot_between(*std::prev(later), *later, header, published_ns);
  }
  // Frames that queued behind one delayed frame count as one late arrival, not as several.
  if (!queued) measure(frame.slot.due_ns, received_ns);
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
PlayoutSchedule::Slot Playout::slot_between(const Frame& earlier, Frame& later,
                                            const wire::PoseFrameHeader& header, int64_t published_ns) const {
  const double whole = sim_step_ns(earlier.header, later.header);
  const double part = sim_step_ns(earlier.header, header);
  const int64_t begin_ns = earlier.slot.due_ns, end_ns = later.slot.due_ns;
  const bool even = part >= 0 && part <= whole && whole > 0 && !jumps(later.header) && !jumps(header);
  const int64_t due_ns =
      even ? begin_ns + static_cast<int64_t>(static_cast<double>(end_ns - begin_ns) * (part / whole))
           : std::clamp(published_ns, begin_ns, end_ns);
  const int64_t from_ns = jumps(header) ? due_ns : std::min(due_ns, later.slot.from_ns);
  later.slot.from_ns = std::max(later.slot.from_ns, due_ns);
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
  const int64_t span = frames_.back().slot.due_ns - frames_.front().slot.due_ns;
  return span / static_cast<int64_t>(frames_.back().header.sequence - frames_.front().header.sequence);
}

std::optional<Playout::Shown> Playout::at(int64_t now_ns) {
  if (frames_.empty()) return {};
  // A rising delay stops motion; it never moves it backwards.
  moment_ns_ = std::max(moment_ns_, now_ns - delay_ns());
  while (frames_.size() > 2 && frames_[1].slot.due_ns <= moment_ns_) {
    drop_oldest();
  }
  for (; spare_.size() > 8; spare_.pop_back()) memory_.give_back(spare_.back().capacity());
  const Frame& earlier = frames_.front();
  const Frame& later = frames_.size() > 1 ? frames_[1] : earlier;
  const auto [from_ns, due_ns] = later.slot;
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
