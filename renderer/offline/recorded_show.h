// A recording as the renderer's pose state shows it at any moment of its timeline, one moment after the
// other. Depends on the moment alone: not on those that were asked for before.
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

class RecordedShow {
 public:
  // Opens the recording once more; each stream is read by itself.
  using Open = std::function<Result<record::Playback>()>;
  // timeline: of the same recording. It and poses are borrowed.
  static Result<RecordedShow> open(const Open& open_recording, const Timeline& timeline,
                                   state::PoseState& poses);

  // Moments never go back. Streams begin and end, edits come and poses are shown as they are to be then.
  void advance(int64_t line_ns);

  // Sentences for the user since the last call.
  std::vector<std::string> take_notes() { return std::exchange(notes_, {}); }
  uint64_t left_out() const;

 private:
  RecordedShow(const Timeline& timeline, state::PoseState& poses) : timeline_(timeline), poses_(poses) {}
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
