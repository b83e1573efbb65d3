// Damage of recordings: verify() finds it, recover() rescues what is intact.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "protocol/record/mcap/reader.h"
#include "protocol/record/mcap/writer.h"

namespace fire3dv::record {

// Result of a full verification: every CRC, and the consistency of redundant fields. Readers check only what
// they read.
struct Report {
  uint64_t messages = 0, chunks = 0, damaged_chunks = 0, attachments = 0, metadata = 0;
  bool data_crc_given = false;
  uint64_t problem_count = 0;
  std::vector<std::string> problems;  // the first hundred, one sentence each
  bool sound() const { return problem_count == 0; }
};

// Also passes every intact message to on_message. Fails only if the disk cannot be read or memory is too
// small.
Result<Report> verify(Reader& reader, const std::function<void(const Message&)>& on_message);

struct Recovered {
  uint64_t messages = 0, chunks = 0, damaged_chunks = 0, attachments = 0, damaged_attachments = 0;
  std::string first_damage;  // for messages; empty: no damage
};

// Writes a valid file with every message of every intact chunk of a truncated or damaged recording.
// Without any message or attachment the sink is not finished: an atomic one leaves no file. on_chunk:
// receives the chunk of each message and the number of chunks.
Result<Recovered> recover(Reader& reader, std::unique_ptr<Sink> sink, const WriterOptions& options = {},
                          const std::function<void(size_t chunk, size_t chunks)>& on_chunk = {});

}  // namespace fire3dv::record
