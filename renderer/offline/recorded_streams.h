// Recorded streams applied to the pose state at ascending times of the timeline. The state is a pure function
// of the time, independent of earlier calls.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "renderer/offline/stream_cursor.h"
#include "renderer/offline/timeline.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::offline {

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
  RecordedStreams(const Timeline& timeline, state::PoseState& poses) : timeline_(timeline), poses_(poses) {}
  struct Stream {
    StreamCursor cursor;
    std::optional<state::StreamId> id;
  };
  Stream* next_until(int64_t line_ns);
  void apply(Stream& stream, const StreamCursor::Effect& effect);
  void begin(Stream& stream, const wire::StreamDescription& description);

  const Timeline& timeline_;
  state::PoseState& poses_;
  std::vector<Stream> streams_;
  wire::Decoder decoder_;
  std::vector<std::string> notes_;
};

}  // namespace fire3dv::offline
