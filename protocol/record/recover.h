// Makes a whole file of what is whole in a cut or damaged one: every message of every chunk that is sound.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "protocol/record/reader.h"
#include "protocol/record/writer.h"

namespace fire3dv::record {

struct Recovered {
  uint64_t messages = 0, chunks = 0, damaged_chunks = 0, attachments = 0, damaged_attachments = 0;
  std::string first_damage;  // for people; empty: none was found
};

Result<Recovered> recover(Reader& reader, std::unique_ptr<Sink> sink, const WriterOptions& options = {});

}  // namespace fire3dv::record
