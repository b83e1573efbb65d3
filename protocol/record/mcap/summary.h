// File index of a recording, from its summary section, or from a scan of all records if the summary is
// missing or damaged.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "protocol/record/mcap/file.h"
#include "protocol/record/mcap/records.h"

namespace fire3dv::record {

struct ReadLimits {
  // Limit on all memory of a reader: compressed chunk, uncompressed chunk, index, and stream state.
  uint64_t memory_bytes = uint64_t{64} << 20;
  uint64_t max_chunk_bytes() const { return memory_bytes / 4; }
  uint64_t max_index_bytes() const { return memory_bytes / 4; }
  uint64_t max_state_bytes() const { return memory_bytes / 4; }
};

struct FileIndex {
  std::map<uint16_t, Schema> schemas;
  std::map<uint16_t, Channel> channels;
  std::vector<ChunkIndex> chunks;  // sorted by file offset; in a Reader by time
  std::vector<AttachmentIndex> attachments;
  std::vector<MetadataIndex> metadata;
  std::optional<Statistics> statistics;
  bool has_summary = false;
  std::string damage;  // reason why the summary is unusable or where the file is truncated; for messages
  // What a whole file does without, so that its data are scanned (a chunk index, say), or why messages come
  // in file order; for messages.
  std::string remark;

  // Fails for an id with a different definition, or for lack of memory.
  Result<void> define(Schema schema, const ReadLimits& limits);
  Result<void> define(Channel channel, const ReadLimits& limits);
  Result<void> take_memory(uint64_t bytes, const ReadLimits& limits);

 private:
  uint64_t memory_ = 0;
};

// Accepts only a summary that is valid in every record and lists every chunk of the file. A result with a
// remark lists no chunks, or not all messages: scan() finds them.
Result<FileIndex> read_summary(Source& source, const ReadLimits& limits);
// Finds all intact records, in whatever state the end of the file is.
Result<FileIndex> scan(Source& source, const ReadLimits& limits);

// Fields of an attachment that precede its data.
struct RecordAt;
Result<AttachmentIndex> read_attachment_head(Source& source, const RecordAt& record);

// Reads the footer and verifies the CRC of the summary.
Result<Footer> read_footer(Source& source);

}  // namespace fire3dv::record
