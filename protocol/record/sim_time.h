// Search of a recording by simulated time, for which MCAP has no index.
#pragma once

#include <cstdint>
#include <optional>

#include "protocol/record/playback.h"

namespace fire3dv::record {

// Log time of a stream's first frame at or after this simulated time. Binary search over the chunks, decoding
// one frame of each. If simulated time restarts within the file, the frame is from one of the runs. Moves the
// playback: call seek() afterwards.
std::optional<uint64_t> log_time_of(Playback& playback, size_t stream, int64_t sim_time_ns);

}  // namespace fire3dv::record
