// What is in a recording: streams, counts, times, rates, gaps, and whether every check sum is right.
#pragma once

#include <string>

#include "protocol/error.h"
#include "protocol/record/summary.h"

namespace fire3dv::inspect {

struct RecordingText {
  std::string text, json;
  bool sound = false;
};

Result<RecordingText> inspect_recording(const std::string& path, const record::ReadLimits& limits);

}  // namespace fire3dv::inspect
