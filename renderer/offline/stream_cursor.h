// One stream of a recording, read from its beginning on: what takes effect when, on the timeline. Reads ahead
// as far as the next frame, and no farther. Each stream has a cursor and a reader of its own, so that one
// that pauses does not make the others' frames pile up.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "protocol/record/playback.h"
#include "renderer/offline/stream_frames.h"
#include "renderer/offline/timeline.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::offline {

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
  // The next one, if there is any; valid until take().
  const Effect* peek();
  Effect take();

  // What is to be seen at a time, all effects up to which were taken: between the frame that was taken last
  // and the next one. Nothing before the first frame of a run. The poses are valid until the next call.
  struct Moment {
    wire::PoseFrameHeader header;
    std::span<const wire::Affine3x4> poses;
    bool changed = false;  // since the last call
  };
  std::optional<Moment> at(int64_t line_ns);

  uint64_t left_out() const { return left_out_; }  // edits, of which too many stand between two frames

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
  size_t runs_ = 0, segments_ = 0;  // begun so far
  uint64_t frames_in_run_ = 0;
  int64_t newest_ns_ = kAlways;  // of all that was queued: effects of a stream never go back

  // Edits since the last frame: of each key the newest, by their order.
  struct Pending {
    uint64_t key, log_time_ns;
    wire::Bytes message;
  };
  std::map<uint64_t, Pending> pending_;
  std::map<uint64_t, uint64_t> order_of_key_;
  uint64_t next_order_ = 0, pending_bytes_ = 0, left_out_ = 0;

  std::optional<Frame> shown_;  // taken last
  std::vector<wire::Affine3x4> between_;
  uint64_t shown_sequence_ = 0, shown_next_ = 0;  // what was asked for last was made of these
  double shown_way_ = -1;
};

}  // namespace fire3dv::offline
