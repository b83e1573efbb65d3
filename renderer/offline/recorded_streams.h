// Recorded streams: decoder and cursor of each stream, and their application to the pose state at ascending
// times of the timeline. The state is a pure function of the time, independent of earlier calls.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "protocol/record/playback.h"
#include "protocol/wire/decode.h"
#include "renderer/offline/timeline.h"
#include "renderer/state/frame_receiver.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::offline {

// Frame decoder of one recorded stream. It yields whole frames in order, assembled from parts and partial
// frames. As in a live renderer, a frame follows the scene edits that it depends on.
class StreamFrames {
 public:
  // Effect of one message. An edit may release a frame that waited for it.
  struct Changes {
    bool began = false, ended = false;
    bool edited = false;
    bool frame = false;  // header() and poses() have a new frame
    // The frame begins a segment: it is the first of a run, or simulator time went back.
    bool segment = false;
  };
  Changes take(const record::Played& played);

  const wire::PoseFrameHeader& header() const { return receiver_->header; }
  std::span<const wire::Affine3x4> poses() const { return receiver_->poses; }
  // Skipped messages by reason.
  struct Unusable {
    uint64_t malformed = 0, other_version = 0, before_description = 0, distant = 0;
    uint64_t count() const { return malformed + other_version + before_description + distant; }
  };
  const Unusable& unusable() const { return unusable_; }

 private:
  wire::Decoder decoder_;
  std::optional<state::FrameReceiver> receiver_;  // of the current run
  std::optional<int64_t> sim_time_ns_;            // of the newest frame of this run
  Unusable unusable_;
};

// Cursor over one stream of a recording: its effects with their times on the timeline, in order. It reads
// ahead to the next frame only. Each stream has its own cursor and reader, so that a paused stream does not
// make frames of the others accumulate.
class StreamCursor {
 public:
  // timeline: of the same file; borrowed.
  StreamCursor(record::Playback playback, size_t stream, const Timeline& timeline);

  struct Frame {
    wire::PoseFrameHeader header;
    std::vector<wire::Affine3x4> poses;
    int64_t at_ns = 0;
    size_t segment = 0;
  };
  struct Effect {
    enum class Kind { begin, edit, frame, end };
    Kind kind = Kind::frame;
    int64_t at_ns = 0;
    uint64_t log_time_ns = 0;
    wire::Bytes message;  // of begin and edit
    Frame frame;
  };
  // Next effect, or null at the end; valid until take().
  const Effect* peek();
  Effect take();

  // Interpolated frame at a time, between the last taken frame and the next one. All effects up to this time
  // must have been taken. nullopt before the first frame of a run. Poses are valid until the next call.
  struct Moment {
    wire::PoseFrameHeader header;
    std::span<const wire::Affine3x4> poses;
    bool changed = false;  // since the last call
  };
  std::optional<Moment> at(int64_t line_ns);

  uint64_t left_out() const { return left_out_; }  // edits over kMaxPendingBytes between two frames

 private:
  void fill();
  void queue(Effect effect);
  void keep_edit(const record::Played& played);
  const Frame* next_frame() const;

  record::Playback playback_;
  size_t stream_;
  const Timeline& timeline_;
  StreamFrames frames_;
  std::deque<Effect> queue_;
  bool at_end_ = false;
  size_t runs_ = 0, segments_ = 0;  // started so far
  uint64_t frames_in_run_ = 0;
  int64_t newest_ns_ = kAlways;  // of all queued effects; effects of a stream are ordered

  // Newest edit of each key since the last frame, in recording order.
  struct Pending {
    uint64_t key, log_time_ns;
    wire::Bytes message;
  };
  std::map<uint64_t, Pending> pending_;
  std::map<uint64_t, uint64_t> order_of_key_;
  uint64_t next_order_ = 0, pending_bytes_ = 0, left_out_ = 0;

  std::optional<Frame> shown_;  // last taken frame
  std::vector<wire::Affine3x4> between_;
  uint64_t shown_sequence_ = 0, shown_next_ = 0;  // cache key of between_, with shown_way_
  double shown_way_ = -1;
};

class RecordedStreams {
 public:
  // Opens the recording again; each stream has its own reader.
  using Open = std::function<Result<record::Playback>()>;
  // timeline: of the same recording. timeline and poses are borrowed.
  static Result<RecordedStreams> open(const Open& open_recording, const Timeline& timeline,
                                      state::PoseState& poses);

  // Applies all effects up to a time and shows the poses at it. Times must not decrease.
  void advance(int64_t line_ns);

  // Returns and clears the messages for the user.
  std::vector<std::string> take_log_messages() { return std::exchange(notes_, {}); }
  uint64_t left_out() const;

 private:
  explicit RecordedStreams(state::PoseState& poses) : poses_(poses) {}
  struct Stream {
    StreamCursor cursor;
    std::optional<state::StreamId> id;
  };
  Stream* next_until(int64_t line_ns);
  void apply(Stream& stream, const StreamCursor::Effect& effect);
  void begin(Stream& stream, const wire::StreamDescription& description);

  state::PoseState& poses_;
  std::vector<Stream> streams_;
  wire::Decoder decoder_;
  std::vector<std::string> notes_;
};

}  // namespace fire3dv::offline
