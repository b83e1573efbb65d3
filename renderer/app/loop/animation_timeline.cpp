#include "renderer/app/loop/animation_timeline.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/clock.h"

namespace fire3dv::app {
namespace {

constexpr double kLongestS = 1e8;  // three years: keeps nanoseconds within 64 bits

uint64_t nanoseconds(double seconds) {
  return static_cast<uint64_t>(std::clamp(seconds, 0.0, kLongestS) * 1e9);
}

}  // namespace

AnimationTimeline::AnimationTimeline(double duration_s, std::function<int64_t()> now_ns)
    : now_ns_(now_ns ? std::move(now_ns) : std::function<int64_t()>(monotonic_ns)),
      duration_ns_(nanoseconds(duration_s)) {
  clock_.set_position(0, now_ns_());
  clock_.set_playing(true, now_ns_());
}

double AnimationTimeline::at(std::optional<int64_t> sim_time_ns) {
  if (sim_time_ns) {
    clock_.set_position(static_cast<uint64_t>(std::max<int64_t>(*sim_time_ns, 0)), now_ns_());
    return static_cast<double>(*sim_time_ns) * 1e-9;
  }
  if (looping_) return static_cast<double>(clock_.position_ns(now_ns_())) * 1e-9;
  // At its last key an animation would begin again.
  return std::nextafter(static_cast<double>(position_ns()) * 1e-9, 0.0);
}

// Within the duration.
uint64_t AnimationTimeline::position_ns() const {
  const uint64_t position = clock_.position_ns(now_ns_());
  if (duration_ns_ == 0) return 0;
  return looping_ ? position % duration_ns_ : std::min(position, duration_ns_);
}

replay::TimelineState AnimationTimeline::timeline() const {
  replay::TimelineState state;
  state.end_ns = duration_ns_;
  state.position_ns = position_ns();
  state.speed = clock_.speed();
  state.playing = clock_.playing();
  state.looping = looping_;
  state.at_end = !looping_ && state.position_ns >= duration_ns_;
  state.can_be_unpaced = false;
  return state;
}

void AnimationTimeline::play() {
  if (timeline().at_end) seek(0);
  clock_.set_playing(true, now_ns_());
}

void AnimationTimeline::pause() {
  clock_.set_playing(false, now_ns_());
}

void AnimationTimeline::seek(uint64_t time_ns) {
  clock_.set_position(std::min(time_ns, duration_ns_), now_ns_());
}

Result<void> AnimationTimeline::seek_sim_time(int64_t sim_time_ns) {
  seek(static_cast<uint64_t>(std::max<int64_t>(sim_time_ns, 0)));
  return {};
}

void AnimationTimeline::set_speed(double speed) {
  clock_.set_speed(speed > 0 ? speed : 1, now_ns_());
}

void AnimationTimeline::set_looping(bool looping) {
  const uint64_t position = position_ns();
  looping_ = looping;
  clock_.set_position(position, now_ns_());
}

// Loops wrap around; without a loop, both ends hold.
void AnimationTimeline::step_by(int64_t ns) {
  pause();
  if (duration_ns_ == 0) return;
  const auto length = static_cast<int64_t>(duration_ns_);
  const int64_t to = static_cast<int64_t>(position_ns()) + ns;
  const int64_t within = looping_ ? (to % length + length) % length : std::clamp<int64_t>(to, 0, length);
  clock_.set_position(static_cast<uint64_t>(within), now_ns_());
}

}  // namespace fire3dv::app
