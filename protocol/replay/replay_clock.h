// Which moment of a recording is now: follows the monotonic clock, faster or slower, and stands still while
// paused.
#pragma once

#include <cstdint>

namespace fire3dv::replay {

class ReplayClock {
 public:
  bool playing() const { return playing_; }
  double speed() const { return speed_; }
  // As fast as can be: every moment has come already.
  bool unpaced() const { return speed_ == 0; }

  uint64_t position_ns(int64_t now_ns) const;
  // When a moment comes, on the monotonic clock; not before it was set.
  int64_t due_ns(uint64_t log_time_ns) const;

  void set_position(uint64_t log_time_ns, int64_t now_ns);
  void set_playing(bool playing, int64_t now_ns);
  void set_speed(double speed, int64_t now_ns);

 private:
  uint64_t log_time_ns_ = 0;  // at that moment
  int64_t at_ns_ = 0;
  double speed_ = 1;
  bool playing_ = false;
};

}  // namespace fire3dv::replay
