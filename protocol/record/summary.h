// What is where in a file: from its summary, or, where that is missing or damaged, from looking at every
// record.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "protocol/record/file.h"
#include "protocol/record/records.h"

namespace fire3dv::record {

struct ReadLimits {
  // For everything that a reader holds of a file: a chunk packed, the same unpacked, the index, the state of
  // streams.
  uint64_t memory_bytes = uint64_t{64} << 20;
  uint64_t most_chunk_bytes() const { return memory_bytes / 4; }
  uint64_t most_index_bytes() const { return memory_bytes / 4; }
  uint64_t most_state_bytes() const { return memory_bytes / 4; }
};

struct FileIndex {
  std::map<uint16_t, Schema> schemas;
  std::map<uint16_t, Channel> channels;
  std::vector<ChunkIndex> chunks;  // by their place in the file
  std::vector<AttachmentIndex> attachments;
  std::vector<MetadataIndex> metadata;
  std::optional<Statistics> statistics;
  uint64_t loose_messages = 0;  // outside of chunks: the format allows it, and this reader does not read them
  bool has_summary = false;
  std::string damage;  // why there is no use in the summary, or where the file ends too early; for people

  // An error for an id that means something else already, or no memory left for it.
  Result<void> define(Schema schema, const ReadLimits& limits);
  Result<void> define(Channel channel, const ReadLimits& limits);
  Result<void> take_memory(uint64_t bytes, const ReadLimits& limits);

 private:
  uint64_t memory_ = 0;
};

// Only a summary that is sound in every record, and that fits the file.
Result<FileIndex> read_summary(Source& source, const ReadLimits& limits);
// All that is whole, whatever the end of the file looks like.
Result<FileIndex> scan(Source& source, const ReadLimits& limits);

// What an attachment says of itself in front of its data.
struct RecordAt;
Result<AttachmentIndex> read_attachment_head(Source& source, const RecordAt& record);

// The footer and the CRC over the summary.
Result<Footer> read_footer(Source& source);

}  // namespace fire3dv::record
