#include "tools/lab/impair/stream_impairment.h"

#include <algorithm>

namespace fire3dv::impair {
namespace {

constexpr double kMostBytes = 1e18;

}  // namespace

StreamImpairment::StreamImpairment(const Impairment& impairment, uint64_t connection, bool to_target)
    : generator_(impairment.seed * 0x9e3779b97f4a7c15u + 2 * connection + to_target),
      jitter_(generator_()),
      stall_after_bytes_(impairment.stall_after_bytes) {
  if (impairment.reset_after_bytes != 0) until_reset_ = draw_bytes(impairment.reset_after_bytes);
  if (stall_after_bytes_ != 0) until_stall_ = draw_bytes(stall_after_bytes_);
}

uint64_t StreamImpairment::draw_bytes(uint64_t mean) {
  std::exponential_distribution<double> distance(1 / static_cast<double>(mean));
  return static_cast<uint64_t>(std::clamp(distance(generator_), 1.0, kMostBytes));
}

uint64_t StreamImpairment::quiet_bytes() const {
  return std::min(until_stall_, until_reset_);
}

bool StreamImpairment::pass(uint64_t bytes) {
  if (until_reset_ != UINT64_MAX) until_reset_ -= std::min(bytes, until_reset_);
  if (until_stall_ == UINT64_MAX) return false;
  until_stall_ -= std::min(bytes, until_stall_);
  if (until_stall_ != 0) return false;
  until_stall_ = draw_bytes(stall_after_bytes_);
  return true;
}

int64_t StreamImpairment::delay_ns(const Impairment& impairment) {
  const double way = std::uniform_real_distribution<double>(-1, 1)(jitter_);
  return std::max<int64_t>(
      0, impairment.delay_ns + static_cast<int64_t>(way * static_cast<double>(impairment.jitter_ns)));
}

}  // namespace fire3dv::impair
