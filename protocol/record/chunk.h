// One chunk of a file: unpacked, checked, and read message by message.
#pragma once

#include <cstdint>
#include <optional>

#include "protocol/error.h"
#include "protocol/record/compress.h"
#include "protocol/record/file.h"
#include "protocol/record/records.h"
#include "protocol/record/walk.h"

namespace fire3dv::record {

// What stands in front of a chunk's packed bytes.
Result<ChunkHead> read_chunk_head(Source& source, const RecordAt& record);

// Unpacks chunks, one after the other, in the same memory: twice the longest of them.
class ChunkReader {
 public:
  explicit ChunkReader(uint64_t most_bytes) : most_bytes_(most_bytes) {}

  // Afterwards the chunk is whole and its records stand one behind the other up to its end, or an error says
  // why not.
  Result<void> load(Source& source, const RecordAt& record);
  const ChunkHead& head() const { return head_; }
  void unload() { at_ = records_.size(); }

  struct Entry {
    Kind kind{};
    uint64_t offset = 0;  // in the unpacked chunk
    std::span<const std::byte> content;
  };
  // Schemas, channels and messages, in the order of the file. Valid until the next load.
  std::optional<Entry> next();
  void rewind() { at_ = 0; }

 private:
  Result<void> check_records(const std::string& where) const;

  uint64_t most_bytes_;
  Compressor compressor_;
  ChunkHead head_;
  Bytes packed_, records_;
  size_t at_ = 0;
};

}  // namespace fire3dv::record
