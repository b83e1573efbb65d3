// Replay pacing: maps log times to wall-clock waits at a playback speed.
#pragma once

#include <cstdint>
#include <optional>

namespace fire3dv::replay {

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
