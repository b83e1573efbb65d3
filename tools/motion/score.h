// How evenly a known motion is seen by whom it reached over a network: with the newest frame at once, and
// interpolated as the renderer does it. From what was recorded, in the recording's own time, so that the same
// recording gives the same figures.
#pragma once

#include <cstdint>
#include <istream>
#include <optional>
#include <string>
#include <vector>

namespace fire3dv::motion {

// Whole frames that are newer than all before them, as a link hands them on.
struct Arrival {
  uint64_t sequence = 0;
  int64_t sim_time_ns = 0;
  uint64_t publish_time_ns = 0;  // publisher's clock; simulated time runs evenly along it
  int64_t received_ns = 0;       // ours
};
using Recording = std::vector<Arrival>;

enum class Way { latest, interpolated };

// The distance between what is seen and the truth a constant while ago: the while that suits best, since a
// steady delay does not make a motion uneven.
struct Score {
  double rms_mm = 0, max_mm = 0;
  double behind_ms = 0;  // that while, and the quickest frame's time on its way is not in it
  // 60 a second, but for the first seconds, in which a delay is found, and for when the stream was late
  // (while no frames come nobody can know the truth) and shortly after.
  uint64_t looks = 0;
};
Score score(const Recording& recording, Way way);

// Text, a line for each frame; the same recording is read as was written. Nothing, where it is none.
std::string text_of(const Recording& recording);
std::optional<Recording> recording_of(std::istream& text);

}  // namespace fire3dv::motion
