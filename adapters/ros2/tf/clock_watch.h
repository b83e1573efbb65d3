// Watch of /clock: simulated time that goes back, and two publishers that disagree.
#pragma once

#include <cstdint>
#include <optional>

#include "adapters/ros2/tf/frames.h"

namespace fire3dv::ros2 {

class ClockWatch {
 public:
  enum class Event {
    none,
    jumped_back,  // by more than a second, or to less than 0.1 s
    conflict      // another publisher sends in turn with the first; its times are ignored
  };

  Event add(int64_t time_ns, SourceId source, int64_t arrival_ns) {
    if (source_ != 0 && source != source_ && arrival_ns - arrival_ns_ < FrameBuffer::kSilenceNs) {
      other_ = source;
      return Event::conflict;
    }
    source_ = source;
    arrival_ns_ = arrival_ns;
    const bool jumps = time_ns_ && (time_ns < *time_ns_ - FrameBuffer::kJumpBackNs ||
                                    (time_ns < kBeginningNs && *time_ns_ >= kBeginningNs));
    time_ns_ = time_ns;
    return jumps ? Event::jumped_back : Event::none;
  }

  std::optional<int64_t> time_ns() const { return time_ns_; }
  SourceId source() const { return source_; }
  SourceId other() const { return other_; }

 private:
  static constexpr int64_t kBeginningNs = 100'000'000;

  std::optional<int64_t> time_ns_;
  SourceId source_ = 0, other_ = 0;
  int64_t arrival_ns_ = 0;
};

}  // namespace fire3dv::ros2
