// Full verification of a recording: every CRC, and the consistency of redundant fields. Readers check only
// what they read.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "protocol/record/mcap/reader.h"

namespace fire3dv::record {

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

}  // namespace fire3dv::record
