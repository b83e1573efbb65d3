// Playback control of a recording, for the timeline panel, scripts and tests. Log times are the recording's,
// in Unix ns.
#pragma once

#include <cstdint>
#include <optional>

#include "protocol/base/error.h"

namespace fire3dv::replay {

struct TimelineState {
  uint64_t start_ns = 0, end_ns = 0;  // played range: all of the recording or a part
  uint64_t position_ns = 0;
  std::optional<int64_t> sim_time_ns;  // simulated time of the newest played frame of any stream
  double speed = 1;
  bool playing = false, looping = false;
  bool at_end = false;            // stopped until seek() or play()
  uint64_t frames = 0;            // played frames of all streams
  uint64_t damaged_chunks = 0;    // skipped
  uint64_t refused_messages = 0;  // invalid, or dropped for lack of memory
};

// Called on the polling thread only. Takes effect with the next poll.
class TimelineControl {
 public:
  virtual ~TimelineControl() = default;

  virtual TimelineState timeline() const = 0;
  // Starts from the beginning if at the end.
  virtual void play() = 0;
  virtual void pause() = 0;
  // Seeks to a log time: shows each stream's newest whole frame up to then, marked as a discontinuity, and
  // the edits in force. Each seek starts a new run of the streams. Preserves the paused state; times outside
  // the recording are clamped.
  virtual void seek(uint64_t log_time_ns) = 0;
  // Seeks to the first chosen stream's first frame at or after this simulated time. If simulated time
  // restarts within the recording, the frame is from one of the runs. Fails if there is none.
  virtual Result<void> seek_sim_time(int64_t sim_time_ns) = 0;
  // Pauses and plays one frame.
  virtual void step() = 0;
  // Sets a factor of the recorded speed; 0: unpaced. NaN and negative values count as 1.
  virtual void set_speed(double speed) = 0;
  virtual void set_looping(bool looping) = 0;
};

}  // namespace fire3dv::replay
