// Options of streams: replay and recording, playout, and the stale overlay of stalled streams.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "renderer/state/pose_state.h"

namespace CLI {
class App;
}

namespace fire3dv::app {

struct RecordingOptions {
  std::string replay;                // MCAP file; empty: none
  std::vector<std::string> streams;  // stream names; empty: all
  double speed = 1, start_s = 0, end_s = 0;
  bool loop = false;
  bool step = false;  // one image per recorded frame

  std::string record;        // MCAP file; empty: none
  double record_sync_s = 1;  // flush interval; 0: only at the end
  bool attach_scene = false;
  bool foxglove = false;
};

void add_recording_options(CLI::App& app, RecordingOptions& options);
// Returns an error message for contradictory options.
std::optional<std::string> check_recording_options(const RecordingOptions& options);

// Streams that get a stale overlay. A local simulator visibly pauses; for a remote one, a pause and lost
// frames look the same.
enum class StaleOverlay {
  interpolated,  // images of interpolated streams
  on,
  off,
};

struct PlayOptions {
  enum class Mode {
    by_clock,     // interpolated for streams of other machines (by boot id), latest for local ones
    latest,       // the newest frame immediately
    interpolate,  // with a delay, evenly
  };
  Mode mode = Mode::by_clock;
  std::optional<int64_t> delay_ns;  // of interpolated streams; unset: adapts to the jitter
  StaleOverlay mark_held = StaleOverlay::interpolated;
};

// Worst condition of all displayed streams that are subject to the mark.
inline state::Condition stale_condition(const std::vector<state::Stream>& streams, StaleOverlay mark) {
  state::Condition worst = state::Condition::live;
  for (const state::Stream& stream : streams) {
    if (!stream.active || stream.header.sequence == 0) continue;
    if (mark == StaleOverlay::off || (mark == StaleOverlay::interpolated && !stream.interpolated)) continue;
    worst = std::max(worst, stream.condition);
  }
  return worst;
}

}  // namespace fire3dv::app
