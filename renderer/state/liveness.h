// Liveness monitor of a stream: live, late or lost, by arrival times of its frames. Viewers mark the images
// of stale streams with it. Times are in nanoseconds. Not thread-safe.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fire3dv::state {

enum class Condition : uint8_t {
  live,  // frames arrive
  // No frame for 0.25 s or for four of the stream's own intervals.
  late,
  lost,  // no frame for seconds
};
constexpr const char* condition_name(Condition condition) {
  constexpr const char* kNames[] = {"live", "late", "lost"};
  return kNames[static_cast<size_t>(condition)];
}

// Input: arrival times of whole frames.
class Liveness {
 public:
  void on_frame(int64_t received_ns);
  // Returns live before the first frame: no stale frame is shown then.
  Condition at(int64_t now_ns) const;
  // Intervals between the newest frames, oldest first, for jitter plots.
  std::vector<float> gaps_ms() const;

 private:
  int64_t late_after_ns() const;

  int64_t last_ns_ = 0;
  int64_t last_gap_ns_ = 0;
  double interval_ns_ = 0;
  static constexpr size_t kMaxGaps = 96;
  std::array<float, kMaxGaps> gaps_ms_{};
  size_t gaps_ = 0;  // count since the start
};

}  // namespace fire3dv::state
