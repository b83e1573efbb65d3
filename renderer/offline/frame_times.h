// Frame schedule of an offline run: frame rate, times of frames and shards. All times are in nanoseconds.
#pragma once

#include <cstdint>
#include <string>

#include "protocol/base/error.h"

namespace fire3dv::offline {

constexpr uint64_t kMaxFrames = 100'000'000;
constexpr int64_t kSecondNs = 1'000'000'000;

// Frames per second as a reduced fraction, since rates such as 30000/1001 are not decimal.
struct FrameRate {
  int64_t numerator = 30, denominator = 1;
  bool operator==(const FrameRate&) const = default;
};

// Parses "30", "29.97" (at most three decimals) or "30000/1001"; 0.001 to 100000 frames per second.
Result<FrameRate> parse_frame_rate(const std::string& text);
std::string to_text(const FrameRate& rate);  // "30" or "30000/1001"

// Frame k has time first_ns + k / rate, rounded down to nanoseconds.
struct FrameTimes {
  int64_t first_ns = 0;
  FrameRate rate;
  uint64_t frames = 0;

  int64_t at_ns(uint64_t frame) const;
};

// Schedules all frames in [first_ns, last_ns]. Fails if there are more than kMaxFrames.
Result<FrameTimes> frame_times(int64_t first_ns, int64_t last_ns, const FrameRate& rate);

// Frame range of shard `index` (from 1) of `count`. Shards cover all frames; their sizes differ by at most
// one.
struct Part {
  uint64_t first = 0, frames = 0;
  bool operator==(const Part&) const = default;
};
Part part_of(uint64_t frames, uint32_t index, uint32_t count);

}  // namespace fire3dv::offline
