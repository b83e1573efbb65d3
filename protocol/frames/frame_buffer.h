// Transform buffer: frames with their parents, and each moving frame's transforms of the last 10 s, by the
// rules of ROS 2's tf2.
//
// Stamps are nanoseconds of the publishers' clock, which may be simulated; arrivals are nanoseconds of this
// machine's monotonic clock. The two are never compared. Names and values come from other programs: each is
// checked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "protocol/frames/transform.h"

namespace fire3dv::frames {

using FrameId = uint32_t;  // index into FrameBuffer::frames()
constexpr FrameId kNoFrame = UINT32_MAX;
using SourceId = uint64_t;  // publisher; 0: none

struct FrameSample {
  int64_t stamp_ns = 0;
  FrameId parent = kNoFrame;
  Transform parent_from_frame;
};

struct Frame {
  std::string name;
  bool is_static = false;             // one value for all times
  bool has_gone_back = false;         // two samples in a row were more than a second older than the newest
  int64_t back_stamp_ns = INT64_MAX;  // the first of them; INT64_MAX: none
  SourceId source = 0;                // publisher of the newest sample
  int64_t arrival_ns = 0;             // of the newest sample
  SourceId other_source = 0;          // another publisher of this frame, if there was one
  int64_t other_arrival_ns = 0;
  std::deque<FrameSample> samples;  // oldest first; none: a root

  bool is_root() const { return samples.empty(); }
  // Moves, and has a stamp: publishers that know no time stamp 0.
  bool is_stamped() const { return !is_static && !samples.empty() && samples.back().stamp_ns != 0; }
};

enum class Insertion {
  accepted,
  repeated,      // the stamp is there already; tf2 keeps the first value
  too_old,       // more than 10 s older than the newest
  bad_name,      // empty, too long, not UTF-8, or with control characters
  same_frame,    // child and parent are one frame
  bad_number,    // NaN or infinite
  bad_rotation,  // the quaternion's length is not 1 within half a percent
  too_many_frames
};
const char* insertion_text(Insertion insertion);  // reason of a refusal, for messages

// Two publishers that send the same frame in turn.
struct FrameConflict {
  FrameId frame;
  SourceId first, second;
};

class FrameBuffer {
 public:
  static constexpr int64_t kCacheNs = 10'000'000'000;
  static constexpr int64_t kSilenceNs = 1'000'000'000;
  static constexpr int64_t kJumpBackNs = 1'000'000'000;
  static constexpr size_t kMaxFrames = 65536;
  static constexpr size_t kMaxSamples = 20000;  // of one frame
  static constexpr size_t kMaxNameBytes = 255;

  // Adds a transform. Names may begin with a slash, as in tf1. parent_from_child's rotation is normalised.
  Insertion insert(std::string_view parent, std::string_view child, int64_t stamp_ns,
                   const Transform& parent_from_child, bool is_static, SourceId source, int64_t arrival_ns);

  // Id of a name without its slash; kNoFrame: unknown.
  FrameId find(std::string_view name) const;
  const std::vector<Frame>& frames() const { return frames_; }

  // Changes when a frame appears, gets another newest parent, or begins or ceases to be static.
  uint64_t structure_version() const { return structure_version_; }
  // Changes when a static or unstamped transform changes its value.
  uint64_t static_version() const { return static_version_; }

  // True when at least half of the frames that have moved within the last second have gone back in time: a
  // recording that loops, or a simulator that was reset.
  bool has_jumped_back(int64_t now_ns);
  // Forgets the transforms of moving frames. Static ones stay, as in tf2.
  void clear_moving();
  // Forgets all transforms of one publisher.
  void remove_source(SourceId source);
  // Transforms before this time are not asked for any more.
  void set_oldest_time(int64_t time_ns) { oldest_ns_ = time_ns; }
  // Frees the transforms before that time of all frames; otherwise a frame frees its own with its next one.
  // Returns the number of those that are left.
  size_t forget_old();

  // The frame's transform at a time, as tf2 has it: none before the oldest and after the newest sample.
  static std::optional<FrameSample> at(const Frame& frame, int64_t time_ns);
  // The same, but the oldest sample before and the newest after.
  static FrameSample clamped(const Frame& frame, int64_t time_ns);

  std::vector<FrameConflict> take_conflicts();

 private:
  FrameId intern(std::string_view name);
  void note_source(Frame& frame, FrameId id, SourceId source, int64_t arrival_ns);
  Insertion insert_moving(Frame& frame, FrameSample&& sample, SourceId source, int64_t arrival_ns);
  void prune(Frame& frame) const;

  struct Hash {
    using is_transparent = void;
    size_t operator()(std::string_view text) const { return std::hash<std::string_view>{}(text); }
  };
  std::vector<Frame> frames_;
  std::unordered_map<std::string, FrameId, Hash, std::equal_to<>> ids_;
  std::vector<FrameConflict> conflicts_;
  uint64_t structure_version_ = 0, static_version_ = 0;
  bool has_gone_back_ = false;  // some frame may have
  int64_t oldest_ns_ = INT64_MIN;
};

}  // namespace fire3dv::frames
