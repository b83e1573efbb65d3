// Arrival records of one peer: which datagrams and which parts of frames have been received.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace fire3dv::transport::udp {

// Lets each datagram counter through once. One that is too old to be remembered counts as a repetition.
class ReplayWindow {
 public:
  bool is_new(uint64_t counter) const;
  // Only what has proved to be the peer's may move the window, or a forged counter would shut the peer out.
  void mark(uint64_t counter);

 private:
  static constexpr uint64_t kSpan = 4096;
  std::array<uint64_t, kSpan / 64> seen_{};
  uint64_t newest_ = 0;
};

// Tells when all parts of a frame have come, and which frames a whole newer one has superseded.
class FrameTracker {
 public:
  // repeated: this part came before.
  enum class Outcome { superseded, repeated, part, whole };
  Outcome part(uint64_t frame, uint16_t part, bool last);
  uint64_t newest_whole() const { return newest_whole_; }
  // Of a frame whose parts need not follow, all that has changed came at once.
  void partial() { ++partials_; }
  // How many of the frames before this whole one, and after the whole one before it, never came.
  uint64_t missed(uint64_t newest_before) {
    const uint64_t gap = newest_whole_ - newest_before - 1;
    return gap - std::min(gap, std::exchange(partials_, 0));
  }

 private:
  struct Building {
    uint64_t frame = 0;
    uint32_t count = 0;  // parts that came
    uint32_t total = 0;  // 0 until the last one came
    std::vector<uint64_t> came;
  };
  static constexpr size_t kMostBuilding = 8;

  std::vector<Building> building_;
  uint64_t newest_whole_ = 0;
  uint64_t partials_ = 0;
};

}  // namespace fire3dv::transport::udp
