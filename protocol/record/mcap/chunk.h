// MCAP chunk reader: decompresses one chunk, verifies it, and iterates over its records.
#pragma once

#include <cstdint>
#include <optional>

#include "protocol/base/error.h"
#include "protocol/record/mcap/compress.h"
#include "protocol/record/mcap/file.h"
#include "protocol/record/mcap/record_iterator.h"
#include "protocol/record/mcap/records.h"

namespace fire3dv::record {

// Reads the fields that precede the compressed bytes of a chunk.
Result<ChunkHead> read_chunk_head(Source& source, const RecordAt& record);

// Reusable chunk decoder. Memory: twice the longest chunk.
class ChunkReader {
 public:
  explicit ChunkReader(uint64_t max_bytes) : max_bytes_(max_bytes) {}

  // Decompresses and validates a chunk: CRC, and records that exactly fill it. On an error the chunk is
  // unusable.
  Result<void> load(Source& source, const RecordAt& record);
  const ChunkHead& head() const { return head_; }
  void unload() { at_ = records_.size(); }

  struct Entry {
    Kind kind{};
    uint64_t offset = 0;  // offset in the uncompressed chunk
    std::span<const std::byte> content;
  };
  // Schemas, channels and messages in file order. The content is valid until the next load().
  std::optional<Entry> next();
  void rewind() { at_ = 0; }

 private:
  Result<void> check_records(const std::string& where) const;

  uint64_t max_bytes_;
  Compressor compressor_;
  ChunkHead head_;
  Bytes packed_, records_;
  size_t at_ = 0;
};

}  // namespace fire3dv::record
