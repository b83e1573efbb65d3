// How frames are shown in time.
#pragma once

#include <cstdint>
#include <optional>

namespace fire3dv::app {

// A simulator on this machine that pauses is seen to; of another machine's nobody knows whether it pauses or
// its frames do not come.
enum class MarkHeld {
  interpolated,  // images of interpolated streams
  on,
  off,
};

struct PlayOptions {
  enum class Mode {
    by_clock,     // interpolated for streams of other machines, as their boot id tells; latest for others
    latest,       // the newest frame at once
    interpolate,  // a little late, evenly
  };
  Mode mode = Mode::by_clock;
  std::optional<int64_t> delay_ns;  // of interpolated streams; nothing: it follows the jitter
  MarkHeld mark_held = MarkHeld::interpolated;
};

}  // namespace fire3dv::app
