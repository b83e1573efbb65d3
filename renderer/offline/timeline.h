// Times of an offline run: the schedule of frames and shards, and the common timeline of all streams of a
// recording, in simulator nanoseconds:
//
// - The timeline is the clock of one stream, the guide. A new segment of the guide (another run, or time that
//   went back) follows the previous one.
// - A stream whose clock agrees with the guide's within 100 ms at the start of a segment uses the guide's
//   timeline. Any other segment starts beside the newest guide frame at that moment and advances at the same
//   rate.
// - Descriptions and goodbyes take effect at the guide's time of their arrival.
//
// The mapping is a pure function of the file. One pass over the file finds it; memory is a few numbers per
// run.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "protocol/record/playback.h"

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

constexpr uint64_t kMaxRecordedFrames = 10'000'000;
constexpr uint32_t kMaxCameras = 1000;

// Frame k has time first_ns + k / rate, rounded down to nanoseconds; or the time of the k-th recorded frame.
struct FrameTimes {
  int64_t first_ns = 0;
  FrameRate rate;
  uint64_t frames = 0;
  bool is_recorded = false;          // rate is not used
  std::vector<int64_t> recorded_ns;  // ascending

  int64_t at_ns(uint64_t frame) const;
};

// Schedules all frames in [first_ns, last_ns]. Fails if there are more than kMaxFrames.
Result<FrameTimes> frame_times(int64_t first_ns, int64_t last_ns, const FrameRate& rate);
// Schedules the recorded frames in [first_ns, last_ns]. recorded_ns: ascending times of all of them.
Result<FrameTimes> recorded_frame_times(int64_t first_ns, int64_t last_ns,
                                        const std::vector<int64_t>& recorded_ns);

// Frame range of shard `index` (from 1) of `count`. Shards cover all frames; their sizes differ by at most
// one.
struct Part {
  uint64_t first = 0, frames = 0;
  bool operator==(const Part&) const = default;
};
Part part_of(uint64_t frames, uint32_t index, uint32_t count);

constexpr int64_t kNever = std::numeric_limits<int64_t>::max(), kAlways = std::numeric_limits<int64_t>::min();

class Timeline {
 public:
  // clock: name of the guide; empty: the stream with the first frame. on_progress: log times read and in
  // total; returning false aborts with an error.
  using OnProgress = std::function<bool(uint64_t done, uint64_t total)>;
  // lists_frames: recorded_ns() is filled.
  static Result<Timeline> read(record::Playback& playback, const std::string& clock,
                               const OnProgress& on_progress, bool lists_frames = false);

  // From a description to a goodbye or to the next description.
  struct Run {
    int64_t first_ns = kNever;  // of its first frame, on the timeline
    uint64_t frames = 0;
  };
  // Range of frames in which simulator time does not go back.
  struct Segment {
    int64_t line_from_sim_ns = 0;  // offset to be added
    int64_t hold_ns = 0;           // larger frame gaps are not interpolated: the earlier frame holds
  };
  struct StreamTimes {
    std::vector<Run> runs;
    std::vector<Segment> segments;
  };

  const std::vector<StreamTimes>& streams() const { return streams_; }  // parallel to Playback::streams()
  const std::string& guide() const { return guide_name_; }
  // First and last frame of all streams.
  int64_t first_ns() const { return first_ns_; }
  int64_t last_ns() const { return last_ns_; }
  uint64_t frames() const { return frames_; }
  // Times of all frames of the guide, ascending, each once; kMaxRecordedFrames + 1 if there are more.
  const std::vector<int64_t>& recorded_ns() const { return recorded_ns_; }
  // Timeline time of the newest guide frame at a log time; kAlways before the first one.
  int64_t guide_at(uint64_t log_time_ns) const;

  // Counts of skipped messages for warnings.
  uint64_t damaged() const { return damaged_; }
  uint64_t unusable() const { return unusable_; }
  // The same for each stream, with the reasons.
  const std::vector<std::string>& unusable_notes() const { return unusable_notes_; }
  // Longest time between two frames of the guide.
  struct Pause {
    int64_t from_ns = 0, length_ns = 0;
  };
  const Pause& longest_pause() const { return longest_pause_; }

 private:
  class Builder;
  void remember(uint64_t log_time_ns, int64_t line_ns);

  std::vector<StreamTimes> streams_;
  std::string guide_name_;
  int64_t first_ns_ = kNever, last_ns_ = kAlways;
  uint64_t frames_ = 0, damaged_ = 0, unusable_ = 0;
  std::vector<std::string> unusable_notes_;
  Pause longest_pause_;
  std::vector<std::pair<uint64_t, int64_t>> guide_;  // log time, timeline time; thinned out
  uint64_t guide_spacing_ns_ = 5'000'000;
  bool lists_frames_ = false;
  std::vector<int64_t> recorded_ns_;
};

}  // namespace fire3dv::offline
