// Conversion record of a robot or scene description file: stamps of its sources and of the converted glTF.
// fire3dv-convert writes it; fire3dv validates it before it reuses a conversion.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "renderer/scene/cache/file_stamp.h"

namespace fire3dv::scene {

struct ConversionRecord {
  FileStamp result;
  struct Source {
    std::filesystem::path file;  // absolute in a record
    FileStamp stamp;
  };
  std::vector<Source> sources;
  std::vector<std::string> warnings;  // without line breaks
};

// sources: stamps from before the conversion read them. begun_ns: CLOCK_REALTIME before the first stamp. A
// source written within one clock tick of the file system is recorded as changed, since a second write would
// be invisible.
ConversionRecord record_of(const std::filesystem::path& result,
                           const std::vector<ConversionRecord::Source>& sources, int64_t begun_ns);

std::string text_of(const ConversionRecord& record);
Result<ConversionRecord> read_conversion_record(const std::filesystem::path& file);

// True if the result is the recorded file and all sources are unchanged.
bool holds(const ConversionRecord& record, const std::filesystem::path& result);

}  // namespace fire3dv::scene
