// How a recording that plays is steered: by a window's timeline, by a script, by a test. Log times are those
// of the recording, nanoseconds of Unix time.
#pragma once

#include <cstdint>
#include <optional>

#include "protocol/error.h"

namespace fire3dv::replay {

struct TimelineState {
  uint64_t start_ns = 0, end_ns = 0;  // of what is played: all of the recording, or a part of it
  uint64_t position_ns = 0;
  std::optional<int64_t> sim_time_ns;  // of the newest frame that was played, of any stream
  double speed = 1;
  bool playing = false, looping = false;
  bool at_end = false;            // nothing comes until somebody seeks or plays again
  uint64_t frames = 0;            // played so far, of all streams
  uint64_t damaged_chunks = 0;    // passed over
  uint64_t refused_messages = 0;  // not understood, or no memory for them
};

// Thread-safety: the thread that polls the link. Takes effect with the next poll.
class TimelineControl {
 public:
  virtual ~TimelineControl() = default;

  virtual TimelineState timeline() const = 0;
  // At the end: from the beginning.
  virtual void play() = 0;
  virtual void pause() = 0;
  // Shows what was shown then: of each stream the newest whole frame up to that moment, marked as a
  // discontinuity, and the edits that were in force. Each seek is a new run of the streams. Plays on or stays
  // paused as before; what is outside of the recording is its nearest end.
  virtual void seek(uint64_t log_time_ns) = 0;
  // To the first frame of that simulated time or later, of the first stream that is played. Where simulated
  // time begins anew within the recording, a frame of one of the runs. An error: there is none.
  virtual Result<void> seek_sim_time(int64_t sim_time_ns) = 0;
  // Pauses, and plays one frame.
  virtual void step() = 0;
  // Times as fast as recorded; 0: as fast as can be. What is no number or negative is taken for 1.
  virtual void set_speed(double speed) = 0;
  virtual void set_looping(bool looping) = 0;
};

}  // namespace fire3dv::replay
