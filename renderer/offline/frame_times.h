// Which moments the frames of a video show.
#pragma once

#include <cstdint>
#include <string>

#include "protocol/error.h"

namespace fire3dv::offline {

constexpr uint64_t kMostFrames = 100'000'000;
constexpr int64_t kSecondNs = 1'000'000'000;

// Frames a second, as a fraction in lowest terms: 30000/1001 is no decimal number.
struct FrameRate {
  int64_t numerator = 30, denominator = 1;
  bool operator==(const FrameRate&) const = default;
};

// "30", "29.97" (three decimals at most) or "30000/1001"; 0.001 to 100000 a second.
Result<FrameRate> parse_frame_rate(const std::string& text);
std::string to_text(const FrameRate& rate);  // "30" or "30000/1001"

// Frame k shows first_ns + k / rate, to the nanosecond below.
struct FrameTimes {
  int64_t first_ns = 0;
  FrameRate rate;
  uint64_t frames = 0;

  int64_t at_ns(uint64_t frame) const;
};

// All frames from first_ns to last_ns, both included. The error says how many are too many.
Result<FrameTimes> frame_times(int64_t first_ns, int64_t last_ns, const FrameRate& rate);

// The part of so many frames that shard `index` (from 1) of `count` draws: all parts together are all frames,
// and none is longer than another by more than one.
struct Part {
  uint64_t first = 0, frames = 0;
  bool operator==(const Part&) const = default;
};
Part part_of(uint64_t frames, uint32_t index, uint32_t count);

}  // namespace fire3dv::offline
