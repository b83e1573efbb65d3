// Selection of images with a stale overlay: the mark of stalled streams.
#pragma once

#include <algorithm>
#include <vector>

#include "renderer/app/options/play_options.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

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
