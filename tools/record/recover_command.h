// Recovery command: fire3dv-record recover CUT.mcap -o WHOLE.mcap copies all intact chunks and attachments of
// a damaged recording.
#pragma once

#include <cstdint>
#include <string>

namespace fire3dv::record {

struct RecoverOptions {
  std::string from, to;
  uint64_t memory_mb = 64;
};

// Returns the exit code.
int recover_file(const RecoverOptions& options);

}  // namespace fire3dv::record
