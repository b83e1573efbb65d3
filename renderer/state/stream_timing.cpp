#include "renderer/state/stream_timing.h"

#include <algorithm>

namespace fire3dv::state {
namespace {

constexpr int64_t kLateNs = 250'000'000, kLostNs = 3'000'000'000;
constexpr double kMaxIntervalNs = 10e9;
constexpr double kIntervalsUntilLate = 4;

}  // namespace

// The interval estimate uses the shorter of two consecutive gaps, so that one pause does not count as
// interval.
void Liveness::on_frame(int64_t received_ns) {
  const int64_t gap_ns = received_ns - last_ns_;
  if (last_ns_ != 0 && gap_ns < 0) return;  // late parts of an older frame
  if (last_ns_ != 0 && last_gap_ns_ != 0) {
    const double usual_ns = std::min(static_cast<double>(std::min(gap_ns, last_gap_ns_)), kMaxIntervalNs);
    interval_ns_ += (usual_ns - interval_ns_) / 4;
  }
  if (last_ns_ != 0) gaps_ms_[gaps_++ % kMaxGaps] = static_cast<float>(static_cast<double>(gap_ns) * 1e-6);
  last_gap_ns_ = last_ns_ != 0 ? gap_ns : 0;
  last_ns_ = received_ns;
}

std::vector<float> Liveness::gaps_ms() const {
  std::vector<float> gaps;
  for (size_t i = gaps_ - std::min(gaps_, kMaxGaps); i < gaps_; ++i) gaps.push_back(gaps_ms_[i % kMaxGaps]);
  return gaps;
}

int64_t Liveness::late_after_ns() const {
  return std::max(kLateNs, static_cast<int64_t>(kIntervalsUntilLate * interval_ns_));
}

Condition Liveness::at(int64_t now_ns) const {
  if (last_ns_ == 0) return Condition::live;
  const int64_t silence_ns = now_ns - last_ns_, late_ns = late_after_ns();
  if (silence_ns > std::max(kLostNs, 2 * late_ns)) return Condition::lost;
  return silence_ns > late_ns ? Condition::late : Condition::live;
}

namespace {

constexpr int64_t kPeriodNs = 1'000'000'000;
constexpr int64_t kFollowFraction = 500;  // slew rate 1/500 of the elapsed time; real clocks drift by less
constexpr int64_t kMaxFollowedNs = 1'000'000'000;  // larger steps are no drift: the estimate jumps

// A peer's clock values are untrusted: the subtraction wraps instead of overflowing.
int64_t difference(int64_t a, uint64_t b) {
  return static_cast<int64_t>(static_cast<uint64_t>(a) - b);
}

}  // namespace

template <size_t count>
ClockOffset::Sample ClockOffset::Best<count>::least() const {
  return *std::min_element(samples.begin(), samples.end(),
                           [](const Sample& a, const Sample& b) { return a.cost_ns < b.cost_ns; });
}

void ClockOffset::same_clock() {
  same_ = true;
}

void ClockOffset::on_pong(int64_t sent_ns, uint64_t answer_ns, int64_t received_ns) {
  if (received_ns < sent_ns) return;
  const int64_t round_trip_ns = received_ns - sent_ns;
  pongs_.add({difference(sent_ns + round_trip_ns / 2, answer_ns), round_trip_ns});
}

void ClockOffset::on_frame(uint64_t publish_ns, int64_t received_ns) {
  const int64_t offset_ns = difference(received_ns, publish_ns);
  if (this_period_.cost_ns == INT64_MAX) period_began_ns_ = received_ns;
  if (received_ns - period_began_ns_ >= kPeriodNs) {
    frame_periods_.add(this_period_);
    this_period_ = {};
    period_began_ns_ = received_ns;
  }
  if (offset_ns < this_period_.cost_ns) this_period_ = {offset_ns, offset_ns};
  follow_shortest_way(received_ns);
}

void ClockOffset::follow_shortest_way(int64_t received_ns) {
  const int64_t passed_ns = std::clamp<int64_t>(received_ns - followed_ns_, 0, kPeriodNs);
  const int64_t longer_ns = difference(shortest_way_ns(), static_cast<uint64_t>(soonest_offset_ns_));
  const bool follows = followed_ns_ != 0 && longer_ns > 0 && longer_ns < kMaxFollowedNs;
  soonest_offset_ns_ =
      follows ? soonest_offset_ns_ + std::min(longer_ns, passed_ns / kFollowFraction) : shortest_way_ns();
  followed_ns_ = received_ns;
}

ClockOffset::Source ClockOffset::source() const {
  if (same_) return Source::same_clock;
  if (pongs_.next != 0) return Source::round_trip;
  return this_period_.cost_ns != INT64_MAX ? Source::one_way : Source::none;
}

int64_t ClockOffset::local_ns(uint64_t publisher_ns) const {
  int64_t offset_ns = 0;
  if (source() == Source::round_trip) offset_ns = pongs_.least().offset_ns;
  if (source() == Source::one_way) offset_ns = shortest_way_ns();
  return static_cast<int64_t>(publisher_ns + static_cast<uint64_t>(offset_ns));
}

int64_t ClockOffset::shortest_way_ns() const {
  return std::min(this_period_.cost_ns, frame_periods_.least().cost_ns);
}

int64_t ClockOffset::soonest_ns(uint64_t publisher_ns) const {
  if (same_ || this_period_.cost_ns == INT64_MAX) return local_ns(publisher_ns);
  return static_cast<int64_t>(publisher_ns + static_cast<uint64_t>(soonest_offset_ns_));
}

int64_t ClockOffset::uncertainty_ns() const {
  return source() == Source::round_trip ? pongs_.least().cost_ns / 2 : 0;
}

}  // namespace fire3dv::state
