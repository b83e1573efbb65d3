// Looks at every byte of a recording: all check sums, and whether what a file says twice is the same both
// times. Readers check less, since they read less.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "protocol/record/reader.h"

namespace fire3dv::record {

struct Report {
  uint64_t messages = 0, chunks = 0, damaged_chunks = 0, attachments = 0, metadata = 0;
  bool data_crc_given = false;
  uint64_t problem_count = 0;
  std::vector<std::string> problems;  // the first hundred, one sentence each
  bool sound() const { return problem_count == 0; }
};

// Also hands on every message that is whole. An error only for a disk that cannot be read, or too little
// memory.
Result<Report> verify(Reader& reader, const std::function<void(const Message&)>& on_message);

}  // namespace fire3dv::record
