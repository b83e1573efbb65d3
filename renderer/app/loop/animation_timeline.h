// Timeline of the scene's animations in a window: plays, pauses, seeks and steps their common time. Main
// thread only.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "protocol/replay/replay_clock.h"

namespace fire3dv::app {

class AnimationTimeline final : public replay::TimelineControl {
 public:
  // duration_s: of the longest animation; shorter ones repeat within it. now_ns: a monotonic clock, for
  // tests.
  explicit AnimationTimeline(double duration_s, std::function<int64_t()> now_ns = {});

  // Time of the animations. A stream's simulated time replaces the timeline's while there is one; afterwards
  // the timeline goes on from there.
  double at(std::optional<int64_t> sim_time_ns);

  replay::TimelineState timeline() const override;
  void play() override;
  void pause() override;
  void seek(uint64_t time_ns) override;
  Result<void> seek_sim_time(int64_t sim_time_ns) override;
  void step() override { step_by(kStepNs); }
  void step_back() override { step_by(-kStepNs); }
  void set_speed(double speed) override;  // 0 counts as 1: animations have no frames of their own
  void set_looping(bool looping) override;

 private:
  static constexpr int64_t kStepNs = 1'000'000'000 / 30;
  uint64_t position_ns() const;
  void step_by(int64_t ns);

  const std::function<int64_t()> now_ns_;
  const uint64_t duration_ns_;
  replay::ReplayClock clock_;
  bool looping_ = true;
};

}  // namespace fire3dv::app
