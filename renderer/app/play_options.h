// How frames are shown in time.
#pragma once

#include <cstdint>
#include <optional>

namespace fire3dv::app {

struct PlayOptions {
  enum class Mode {
    by_clock,     // interpolated for streams of other machines, as their boot id tells; latest for others
    latest,       // the newest frame at once
    interpolate,  // a little late, evenly
  };
  Mode mode = Mode::by_clock;
  std::optional<int64_t> delay_ns;  // of interpolated streams; nothing: it follows the jitter
};

}  // namespace fire3dv::app
