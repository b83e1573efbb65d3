// Playout of streams, and the stale overlay of stalled ones.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "renderer/state/pose_state.h"

namespace fire3dv::app {

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
