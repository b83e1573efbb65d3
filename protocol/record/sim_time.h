// Finds a moment of a recording by simulated time, which no index has.
#pragma once

#include <cstdint>
#include <optional>

#include "protocol/record/playback.h"

namespace fire3dv::record {

// The log time of the first frame of a stream that is of this simulated time or a later one: by halves over
// the chunks, a look into one frame each. Where simulated time begins anew within the file, of one of the
// runs. Moves the playback: seek afterwards.
std::optional<uint64_t> log_time_of(Playback& playback, size_t stream, int64_t sim_time_ns);

}  // namespace fire3dv::record
