// Playback position of a recording: follows the monotonic clock at a playback speed, and stops while paused.
#pragma once

#include <cstdint>
#include <optional>

namespace fire3dv::replay {

class ReplayClock {
 public:
  bool playing() const { return playing_; }
  double speed() const { return speed_; }
  // Unpaced playback: every message is due.
  bool unpaced() const { return speed_ == 0; }

  uint64_t position_ns(int64_t now_ns) const;
  // Time on the monotonic clock at which a message is due; never before the position was set.
  int64_t due_ns(uint64_t log_time_ns) const;

  void set_position(uint64_t log_time_ns, int64_t now_ns);
  void set_playing(bool playing, int64_t now_ns);
  void set_speed(double speed, int64_t now_ns);

 private:
  uint64_t log_time_ns_ = 0;  // position at at_ns_
  int64_t at_ns_ = 0;
  double speed_ = 1;
  bool playing_ = false;
};

// Replay pacing without seeking: maps log times to waits at a playback speed.
class Pacer {
 public:
  // speed 0: unpaced.
  explicit Pacer(double speed) : speed_(speed) {}

  // Makes the next message due immediately: at the beginning and after a seek.
  void restart() { begun_.reset(); }
  // Time from now_ns until the message is due, in ns; never negative.
  int64_t wait_ns(uint64_t log_time_ns, int64_t now_ns);

 private:
  struct Begun {
    uint64_t log_time_ns;
    int64_t at_ns;
  };
  double speed_;
  std::optional<Begun> begun_;
};

}  // namespace fire3dv::replay
