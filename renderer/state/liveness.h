// How a stream stands, for people: a picture that is held must not pass for one that lives.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fire3dv::state {

enum class Condition : uint8_t {
  live,  // frames come
  late,  // none has come for a quarter of a second, or for four of the stream's own intervals
  lost,  // none has come for seconds
};
constexpr const char* condition_name(Condition condition) {
  constexpr const char* kNames[] = {"live", "late", "lost"};
  return kNames[static_cast<size_t>(condition)];
}

// From the times at which whole frames come.
class Liveness {
 public:
  void on_frame(int64_t received_ns);
  // Live as long as no frame has come at all: nothing is held then.
  Condition at(int64_t now_ns) const;
  // Between the newest frames, the oldest first: how evenly they come, for people to look at.
  std::vector<float> gaps_ms() const;

 private:
  int64_t late_after_ns() const;

  int64_t last_ns_ = 0;
  int64_t last_gap_ns_ = 0;
  double interval_ns_ = 0;
  static constexpr size_t kGapsKept = 96;
  std::array<float, kGapsKept> gaps_ms_{};
  size_t gaps_ = 0;  // ever
};

}  // namespace fire3dv::state
