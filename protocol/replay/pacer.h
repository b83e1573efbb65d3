// When a recorded moment is due: wall time that follows log times, faster or slower.
#pragma once

#include <cstdint>
#include <optional>

namespace fire3dv::replay {

class Pacer {
 public:
  // 0: as fast as can be.
  explicit Pacer(double speed) : speed_(speed) {}

  // The next moment is due at once: the beginning, or after a jump.
  void restart() { begun_.reset(); }
  // How long until then, from now on; not negative.
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
