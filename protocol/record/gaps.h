// Sentences about the frames that a recording lacks.
#pragma once

#include <optional>
#include <string>

#include "protocol/record/log_thread.h"

namespace fire3dv::record {

// Numbers of missing and incomplete frames of each stream; nothing if the recording has all frames.
std::optional<std::string> describe_gaps(const LogStatus& status);

}  // namespace fire3dv::record
