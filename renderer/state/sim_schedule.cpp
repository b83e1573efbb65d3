#include "renderer/state/sim_schedule.h"

#include <algorithm>
#include <cmath>

namespace fire3dv::state {
namespace {

constexpr double kFollowNs = 300e6;  // how fast the line follows another pace
constexpr double kMostOffNs = 50e6;  // a frame is never due farther than this from when it was published
constexpr double kStandstillNs = 250e6;
constexpr uint32_t kMostMeasured = 1000;  // from then on the line forgets at the same pace for ever

// Of two times of which a stranger chose one: sums wrap around instead of overflowing.
int64_t difference(int64_t a, int64_t b) {
  return static_cast<int64_t>(static_cast<uint64_t>(a) - static_cast<uint64_t>(b));
}

}  // namespace

SimSchedule::Place SimSchedule::next(int64_t sim_ns, int64_t published_ns, bool jump) {
  const auto step_ns = static_cast<double>(difference(sim_ns, sim_ns_));
  const auto gap_ns = static_cast<double>(published_ns - published_ns_);
  const bool first = !begun_;
  begun_ = true;
  sim_ns_ = sim_ns;
  published_ns_ = published_ns;
  if (first || jump || step_ns < 0) return begin_at(std::max(published_ns, due_ns_));
  const int64_t from_ns = due_ns_;
  if (step_ns == 0) {  // the simulator pauses, but what it shows may change
    due_ns_ = std::max(due_ns_, published_ns);
    return {from_ns, due_ns_};
  }

  const double expected_ns = measured_ > 0 ? ns_per_sim_ns_ * step_ns : gap_ns;
  const double error_ns = static_cast<double>(published_ns - due_ns_) - expected_ns;
  if (error_ns > kStandstillNs) {
    // It stood still and goes on: the body stays where it is until it has to leave. Twice in a row is no
    // pause, but another pace.
    if (stood_still_) measured_ = 0;
    stood_still_ = true;
    due_ns_ = published_ns;
    const double way_ns = std::min(expected_ns, gap_ns);
    return {std::max(from_ns, due_ns_ - static_cast<int64_t>(way_ns)), due_ns_};
  }
  stood_still_ = false;
  const double place_gain = measure(step_ns, expected_ns, error_ns);
  const double off_ns = (place_gain - 1) * error_ns;  // due, less published
  if (std::abs(off_ns) > kMostOffNs) {                // another pace: a new line begins here
    measured_ = 1;
    ns_per_sim_ns_ = gap_ns / step_ns;
  }
  due_ns_ =
      std::max(from_ns, published_ns + static_cast<int64_t>(std::clamp(off_ns, -kMostOffNs, kMostOffNs)));
  return {from_ns, due_ns_};
}

SimSchedule::Place SimSchedule::begin_at(int64_t due_ns) {
  due_ns_ = due_ns;
  stood_still_ = false;
  return {due_ns, due_ns};
}

// A straight line through all that came, which forgets what is old: the gains of a least-squares fit at
// first, then those of a critically damped filter. They go by the time that should have passed: frames of a
// burst weigh as much as others.
double SimSchedule::measure(double step_ns, double expected_ns, double error_ns) {
  measured_ = std::min(measured_ + 1, kMostMeasured);
  const double k = measured_;
  const double steady = 1 - std::exp(-expected_ns / kFollowNs);
  const double pace_gain = std::max(steady * steady / (2 - steady), 6 / ((k + 1) * (k + 2)));
  if (measured_ == 1) ns_per_sim_ns_ = expected_ns / step_ns;
  ns_per_sim_ns_ = std::max(0.0, ns_per_sim_ns_ + pace_gain * error_ns / step_ns);
  return std::max(steady, (4 * k + 2) / ((k + 1) * (k + 2)));
}

}  // namespace fire3dv::state
