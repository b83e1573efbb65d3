#include "protocol/replay/replay_clock.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace fire3dv::replay {

namespace {

constexpr double kLongestNs = 1e17;  // three years: upper limit of a wait; prevents overflow of sums

}  // namespace

uint64_t ReplayClock::position_ns(int64_t now_ns) const {
  if (!playing_ || speed_ == 0 || now_ns <= at_ns_) return log_time_ns_;
  const double after_ns = static_cast<double>(now_ns - at_ns_) * speed_;
  const auto whole_ns = static_cast<uint64_t>(std::min(after_ns, kLongestNs));
  return log_time_ns_ > UINT64_MAX - whole_ns ? UINT64_MAX : log_time_ns_ + whole_ns;
}

int64_t ReplayClock::due_ns(uint64_t log_time_ns) const {
  if (speed_ == 0 || log_time_ns <= log_time_ns_) return at_ns_;
  const double after_ns = static_cast<double>(log_time_ns - log_time_ns_) / speed_;
  return at_ns_ + static_cast<int64_t>(std::min(after_ns, kLongestNs));
}

void ReplayClock::set_position(uint64_t log_time_ns, int64_t now_ns) {
  log_time_ns_ = log_time_ns;
  at_ns_ = now_ns;
}

void ReplayClock::set_playing(bool playing, int64_t now_ns) {
  set_position(position_ns(now_ns), now_ns);
  playing_ = playing;
}

void ReplayClock::set_speed(double speed, int64_t now_ns) {
  set_position(position_ns(now_ns), now_ns);
  speed_ = std::isfinite(speed) && speed >= 0 ? speed : 1;
}

std::string long_wait_text(int64_t wait_ns, uint64_t position_ns) {
  char text[200];
  std::snprintf(
      text, sizeof text,
      "the recording has no message for a while: the next one comes in %.1f s; seek, or begin behind "
      "the pause with --start %.1f",
      static_cast<double>(wait_ns) * 1e-9, static_cast<double>(position_ns) * 1e-9);
  return text;
}

int64_t Pacer::wait_ns(uint64_t log_time_ns, int64_t now_ns) {
  if (!begun_) begun_ = Begun{log_time_ns, now_ns};
  if (speed_ <= 0 || log_time_ns <= begun_->log_time_ns) return 0;
  const double after_ns = static_cast<double>(log_time_ns - begun_->log_time_ns) / speed_;
  const auto due_ns = begun_->at_ns + static_cast<int64_t>(std::min(after_ns, kLongestNs));
  return std::max<int64_t>(0, due_ns - now_ns);
}

}  // namespace fire3dv::replay
