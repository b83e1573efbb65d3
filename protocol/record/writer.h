// Writes one MCAP file, chunk by chunk. What is in the file at any moment is whole up to its last chunk;
// finish() adds the summary, by which readers find their way. Memory: one chunk, and an index entry for each
// chunk.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "protocol/record/compress.h"
#include "protocol/record/file.h"
#include "protocol/record/records.h"

namespace fire3dv::record {

struct WriterOptions {
  Compression compression = Compression::zstd;
  size_t chunk_bytes = size_t{1} << 20;  // a chunk ends when it holds so much; a longer message has one alone
};

class Writer {
 public:
  // Writes the header at once, so that a full disk says so here.
  static Result<Writer> open(std::unique_ptr<Sink> sink, const WriterOptions& options = {});

  // Definitions stand outside of chunks: one that is damaged takes only its own messages with it.
  Result<uint16_t> add_schema(const std::string& name, const std::string& encoding,
                              std::span<const std::byte> data);
  Result<uint16_t> add_channel(uint16_t schema_id, const std::string& topic,
                               const std::string& message_encoding, const Texts& metadata);

  // An error says that the chunk which ended with this message could not be written. Its messages are lost;
  // the file is whole up to there.
  Result<void> write(const Message& message);
  Result<void> end_chunk();
  // Ends the chunk and flushes the file to the disk: every message until now survives a power cut.
  Result<void> flush();

  Result<void> attach(const AttachmentIndex& about,
                      Source& data);  // name, media type and times of `about` count
  Result<void> add_metadata(const Metadata& metadata);

  // Summary and footer, flushed to the disk. Worth a try after an error, too: there may be room for them
  // where a chunk was too long.
  Result<void> finish();

  bool chunk_is_empty() const { return chunk_.empty(); }
  size_t chunk_bytes() const { return chunk_.size(); }
  uint64_t file_bytes() const { return position_; }  // without the chunk that is being filled
  uint64_t messages() const { return statistics_.messages; }
  uint64_t chunks() const { return chunk_indexes_.size(); }

 private:
  Writer(std::unique_ptr<Sink> sink, const WriterOptions& options)
      : sink_(std::move(sink)), options_(options) {}

  // All of `record` or nothing of it is in the file afterwards.
  Result<void> append_whole(std::span<const std::byte> record);
  void count(const ChunkHead& head);

  std::unique_ptr<Sink> sink_;
  WriterOptions options_;
  Compressor compressor_;
  uint64_t position_ = 0;
  uint32_t data_crc_ = 0;  // of all that is in the file

  Bytes chunk_;  // the records of the one that is being filled
  uint64_t chunk_start_ns_ = 0, chunk_end_ns_ = 0;
  std::map<uint16_t, MessageIndex> chunk_messages_;  // by channel; kept for their memory
  Bytes record_;

  std::vector<Schema> schemas_;
  std::vector<Channel> channels_;
  std::vector<ChunkIndex> chunk_indexes_;
  std::vector<AttachmentIndex> attachments_;
  std::vector<MetadataIndex> metadata_;
  Statistics statistics_;
};

}  // namespace fire3dv::record
