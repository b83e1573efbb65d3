#include "renderer/state/liveness.h"

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

}  // namespace fire3dv::state
