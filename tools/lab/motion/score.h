// Reference motion, defined at any simulated time, and the score of its smoothness after a network: for
// display of the newest frame and for the renderer's interpolation. The score depends on the recording only.
#pragma once

#include <cstdint>
#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "protocol/wire/messages.h"

namespace fire3dv::motion {

// Arrival of a whole frame that is newer than all earlier ones.
struct Arrival {
  uint64_t sequence = 0;
  int64_t sim_time_ns = 0;
  uint64_t publish_time_ns = 0;  // publisher's clock; simulated time advances evenly with it
  int64_t received_ns = 0;       // receiver's clock
};
using Recording = std::vector<Arrival>;

enum class Way { latest, interpolated };

// Error between displayed and true pose at a constant delay. The delay is fitted, since a steady delay does
// not affect smoothness.
struct Score {
  double rms_mm = 0, max_mm = 0;
  double behind_ms = 0;  // fitted delay beyond the transit time of the fastest frame
  // Samples, 60 per second. Excluded are the first seconds, in which the playout delay settles, and
  // interruptions of the stream with a short time after them, where the true pose is unknown to any receiver.
  uint64_t samples = 0;
};
Score score(const Recording& recording, Way way);

// Text format with one line per frame, lossless. Returns nothing for other text.
std::string text_of(const Recording& recording);
std::optional<Recording> recording_of(std::istream& text);

wire::Affine3x4 reference_pose(int64_t sim_time_ns);

double distance_m(const wire::Affine3x4& a, const wire::Affine3x4& b);

}  // namespace fire3dv::motion
