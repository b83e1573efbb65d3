#include "renderer/state/playout/playout_schedule.h"

#include <algorithm>
#include <cmath>

namespace fire3dv::state {
namespace {

constexpr double kFollowNs = 300e6;  // time constant of the filter
constexpr double kMaxOffNs = 50e6;  // maximum distance of due time and publish time
constexpr double kStandstillNs = 250e6;
constexpr uint32_t kMaxMeasured = 1000;  // then the filter is in steady state

// Simulator times are untrusted: the subtraction wraps instead of overflowing.
int64_t difference(int64_t a, int64_t b) {
  return static_cast<int64_t>(static_cast<uint64_t>(a) - static_cast<uint64_t>(b));
}

}  // namespace

PlayoutSchedule::Place PlayoutSchedule::next(int64_t sim_ns, int64_t published_ns, bool jump) {
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
  const double place_gain = measure(step_ns, expected_ns, error_ns);
  const double off_ns = (place_gain - 1) * error_ns;  // due time minus publish time
  if (std::abs(off_ns) > kMaxOffNs) {                // new rate: restart the line
    measured_ = 1;
    ns_per_sim_ns_ = gap_ns / step_ns;
  }
  due_ns_ =
      std::max(from_ns, published_ns + static_cast<int64_t>(std::clamp(off_ns, -kMaxOffNs, kMaxOffNs)));
  return {from_ns, due_ns_};
}

PlayoutSchedule::Place PlayoutSchedule::begin_at(int64_t due_ns) {
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

}  // namespace fire3dv::state
