// Recovery of truncated or damaged recordings: writes a valid file with every message of every intact chunk.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "protocol/record/mcap/reader.h"
#include "protocol/record/mcap/writer.h"

namespace fire3dv::record {

struct Recovered {
  uint64_t messages = 0, chunks = 0, damaged_chunks = 0, attachments = 0, damaged_attachments = 0;
  std::string first_damage;  // for messages; empty: no damage
};

Result<Recovered> recover(Reader& reader, std::unique_ptr<Sink> sink, const WriterOptions& options = {});

}  // namespace fire3dv::record
