// What a description was when it was converted to glTF, so that a later start can tell whether that still
// holds. Written by fire3dv-convert, read by fire3dv.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "renderer/scene/file_stamp.h"

namespace fire3dv::scene {

struct ConversionRecord {
  FileStamp result;
  struct Source {
    std::filesystem::path file;  // absolute, in a record
    FileStamp stamp;
  };
  std::vector<Source> sources;
  std::vector<std::string> warnings;  // without line breaks
};

// sources: as they were before they were read. begun_ns: the clock of today (CLOCK_REALTIME) before the first
// of them was. A source that was written since, so that a second write within a tick of the file system's
// clock would not be seen, is recorded as one that has changed.
ConversionRecord record_of(const std::filesystem::path& result,
                           const std::vector<ConversionRecord::Source>& sources, int64_t begun_ns);

std::string text_of(const ConversionRecord& record);
Result<ConversionRecord> read_conversion_record(const std::filesystem::path& file);

// Whether the result is the one that was recorded, and its sources are what they were.
bool holds(const ConversionRecord& record, const std::filesystem::path& result);

}  // namespace fire3dv::scene
