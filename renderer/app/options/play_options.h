// Playout options of streams.
#pragma once

#include <cstdint>
#include <optional>

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

}  // namespace fire3dv::app
