// Where the frames of all streams of a recording stand on one line of simulated time:
//
// - The line is the clock of one stream, the guide. Where its time begins anew (another run, or time that
// went back),
//   the new segment follows the one before.
// - Another stream whose clock shows the same as the guide's (within 100 ms, when a segment of it begins) is
// read by
//   it. Any other is laid where it began, beside the frame of the guide that was the newest then, and from
//   there on a second of one is a second of the other.
// - Descriptions and goodbyes take effect where the guide was when they came.
//
// So what is shown at a moment follows from the file alone. One pass over the file finds it; memory is a few
// numbers for each run.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "protocol/error.h"
#include "protocol/record/playback.h"

namespace fire3dv::offline {

constexpr int64_t kNever = std::numeric_limits<int64_t>::max(), kAlways = std::numeric_limits<int64_t>::min();

class Timeline {
 public:
  // clock: the guide's name; empty: the stream whose first frame comes first. on_progress: log times, done
  // and all; false ends the reading with an error.
  using OnProgress = std::function<bool(uint64_t done, uint64_t total)>;
  static Result<Timeline> read(record::Playback& playback, const std::string& clock,
                               const OnProgress& on_progress);

  // From a description to a goodbye or to the next description.
  struct Run {
    int64_t first_ns = kNever;  // of its first frame, on the line
    uint64_t frames = 0;
  };
  // In which simulated time does not go back.
  struct Segment {
    int64_t line_from_sim_ns = 0;  // to be added
    int64_t hold_ns = 0;           // frames farther apart are not joined: nothing moves until the later one
  };
  struct StreamTimes {
    std::vector<Run> runs;
    std::vector<Segment> segments;
  };

  const std::vector<StreamTimes>& streams() const { return streams_; }  // as Playback::streams()
  const std::string& guide() const { return guide_name_; }
  // Of the first and the last frame of all streams.
  int64_t first_ns() const { return first_ns_; }
  int64_t last_ns() const { return last_ns_; }
  uint64_t frames() const { return frames_; }
  // Of the newest frame of the guide that had come by then; kAlways before the first.
  int64_t guide_at(uint64_t log_time_ns) const;

  // For the user: what was passed over.
  uint64_t damaged() const { return damaged_; }
  uint64_t unusable() const { return unusable_; }

 private:
  class Builder;
  void remember(uint64_t log_time_ns, int64_t line_ns);

  std::vector<StreamTimes> streams_;
  std::string guide_name_;
  int64_t first_ns_ = kNever, last_ns_ = kAlways;
  uint64_t frames_ = 0, damaged_ = 0, unusable_ = 0;
  std::vector<std::pair<uint64_t, int64_t>> guide_;  // log time, line; not each frame
  uint64_t guide_spacing_ns_ = 5'000'000;
};

}  // namespace fire3dv::offline
