// Time of a replay: its clock, and the control of its timeline. Log times are the recording's, in Unix ns.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/error.h"

namespace fire3dv::replay {

// Playback position of a recording: follows the monotonic clock at a playback speed, and stops while paused.
class ReplayClock {
 public:
  bool playing() const { return playing_; }
  double speed() const { return speed_; }
  // Unpaced playback: every message is due.
  bool unpaced() const { return speed_ == 0; }

  uint64_t position_ns(int64_t now_ns) const;
  // Time on the monotonic clock at which a message is due; never before the position was set.
  int64_t due_ns(uint64_t log_time_ns) const;

  void set_position(uint64_t log_time_ns, int64_t now_ns);
  void set_playing(bool playing, int64_t now_ns);
  void set_speed(double speed, int64_t now_ns);

 private:
  uint64_t log_time_ns_ = 0;  // position at at_ns_
  int64_t at_ns_ = 0;
  double speed_ = 1;
  bool playing_ = false;
};

// Replay pacing without seeking: maps log times to waits at a playback speed.
class Pacer {
 public:
  // speed 0: unpaced.
  explicit Pacer(double speed) : speed_(speed) {}

  // Makes the next message due immediately: at the beginning and after a seek.
  void restart() { begun_.reset(); }
  // Time from now_ns until the message is due, in ns; never negative.
  int64_t wait_ns(uint64_t log_time_ns, int64_t now_ns);

 private:
  struct Begun {
    uint64_t log_time_ns;
    int64_t at_ns;
  };
  double speed_;
  std::optional<Begun> begun_;
};

// A pause of a recording that is reported when the replay comes to it.
constexpr int64_t kLongWaitNs = 10'000'000'000;
// wait_ns: until the next message; position_ns: its time from the start of the recording.
std::string long_wait_text(int64_t wait_ns, uint64_t position_ns);

struct TimelineState {
  uint64_t start_ns = 0, end_ns = 0;  // played range: all of the recording or a part
  uint64_t position_ns = 0;
  std::optional<int64_t> sim_time_ns;  // simulated time of the newest played frame of any stream
  double speed = 1;
  bool playing = false, looping = false;
  bool at_end = false;            // stopped until seek() or play()
  bool can_be_unpaced = true;     // set_speed(0) has an effect
  uint64_t frames = 0;            // played frames of all streams
  uint64_t damaged_chunks = 0;    // skipped
  uint64_t refused_messages = 0;  // invalid, or dropped for lack of memory
};

// Playback control, for the timeline panel, scripts and tests. Called on the polling thread only. Takes
// effect with the next poll.
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
  // Pauses and shows the frame before the shown one. No effect at the first frame.
  virtual void step_back() = 0;
  // Sets a factor of the recorded speed; 0: unpaced. NaN and negative values count as 1.
  virtual void set_speed(double speed) = 0;
  virtual void set_looping(bool looping) = 0;
};

}  // namespace fire3dv::replay
