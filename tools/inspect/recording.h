// Summary of a recording: streams, counts, times, rates, gaps and checksum validation.
#pragma once

#include <string>

#include "protocol/base/error.h"
#include "protocol/record/mcap/summary.h"

namespace fire3dv::inspect {

struct RecordingText {
  std::string text, json;
  bool sound = false;
};

Result<RecordingText> inspect_recording(const std::string& path, const record::ReadLimits& limits);

}  // namespace fire3dv::inspect
