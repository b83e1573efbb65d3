#include "protocol/replay/pacer.h"

#include <algorithm>

namespace fire3dv::replay {
namespace {

constexpr double kLongestNs = 1e17;  // three years: upper limit of a wait, whatever the recording claims

}  // namespace

int64_t Pacer::wait_ns(uint64_t log_time_ns, int64_t now_ns) {
  if (!begun_) begun_ = Begun{log_time_ns, now_ns};
  if (speed_ <= 0 || log_time_ns <= begun_->log_time_ns) return 0;
  const double after_ns = static_cast<double>(log_time_ns - begun_->log_time_ns) / speed_;
  const auto due_ns = begun_->at_ns + static_cast<int64_t>(std::min(after_ns, kLongestNs));
  return std::max<int64_t>(0, due_ns - now_ns);
}

}  // namespace fire3dv::replay
