// Which images are marked because they show a stream that sends no frames.
#pragma once

#include <algorithm>
#include <vector>

#include "renderer/app/play_options.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

// The worst condition of a stream whose poses are held in the picture and are to be marked.
inline state::Condition condition_to_mark(const std::vector<state::Stream>& streams, MarkHeld mark) {
  state::Condition worst = state::Condition::live;
  for (const state::Stream& stream : streams) {
    if (!stream.active || stream.header.sequence == 0) continue;
    if (mark == MarkHeld::off || (mark == MarkHeld::interpolated && !stream.interpolated)) continue;
    worst = std::max(worst, stream.condition);
  }
  return worst;
}

}  // namespace fire3dv::app
