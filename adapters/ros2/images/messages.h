// Parts of ROS messages that borrow memory of ours: idlc's C structures have pointers that are not const, and
// DDS only reads what it writes.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>

#include "adapters/ros2/dds/topics.h"

namespace fire3dv::ros2 {

inline char* text_of(const char* text) {
  return const_cast<char*>(text);
}
inline char* text_of(const std::string& text) {
  return const_cast<char*>(text.c_str());
}

// Nanoseconds as ROS has them: seconds rounded down, and a positive rest. Times beyond 2038 or before 1901,
// in seconds of 32 bits, are the limit.
inline builtin_interfaces_msg_dds__Time_ ros_time(int64_t nanoseconds) {
  constexpr int64_t kSecond = 1'000'000'000;
  int64_t seconds = nanoseconds / kSecond;
  int64_t rest = nanoseconds % kSecond;
  if (rest < 0) {
    rest += kSecond;
    --seconds;
  }
  using Limits = std::numeric_limits<int32_t>;
  if (seconds < Limits::min()) return {Limits::min(), 0};
  if (seconds > Limits::max()) return {Limits::max(), 999'999'999};
  return {static_cast<int32_t>(seconds), static_cast<uint32_t>(rest)};
}

// The frame must outlive the header.
inline std_msgs_msg_dds__Header_ header_of(int64_t stamp_ns, const std::string& frame) {
  return {ros_time(stamp_ns), text_of(frame)};
}

inline dds_sequence_uint8 sequence_of(std::span<const uint8_t> bytes) {
  const auto size = static_cast<uint32_t>(bytes.size());
  return {size, size, const_cast<uint8_t*>(bytes.data()), false};
}

}  // namespace fire3dv::ros2
