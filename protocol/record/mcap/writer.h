// MCAP writer, chunk by chunk. The file is valid up to its last complete chunk at any time; finish() adds the
// summary. Memory: one chunk and an index entry per chunk.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "protocol/record/mcap/bytes.h"
#include "protocol/record/mcap/file.h"
#include "protocol/record/mcap/records.h"

namespace fire3dv::record {

struct WriterOptions {
  Compression compression = Compression::zstd;
  size_t chunk_bytes = size_t{1} << 20;  // a chunk ends at this size; a longer message gets its own chunk
};

class Writer {
 public:
  // Writes the header immediately, so that a full disk is reported here.
  static Result<Writer> open(std::unique_ptr<Sink> sink, const WriterOptions& options = {});

  // Definitions are outside chunks: a damaged one affects only its own messages.
  Result<uint16_t> add_schema(const std::string& name, const std::string& encoding,
                              std::span<const std::byte> data);
  Result<uint16_t> add_channel(uint16_t schema_id, const std::string& topic,
                               const std::string& message_encoding, const Texts& metadata);

  // An error means that the chunk which this message completed was not written. Its messages are lost; the
  // file is valid up to there.
  Result<void> write(const Message& message);
  Result<void> end_chunk();
  // Ends the chunk and flushes the file to the disk: all messages so far survive a power cut.
  Result<void> flush();

  Result<void> attach(const AttachmentIndex& about,
                      Source& data);  // uses the name, media type and times of `about`
  Result<void> add_metadata(const Metadata& metadata);

  // Writes summary and footer and flushes them. Also worth a call after an error: they may fit where a chunk
  // did not.
  Result<void> finish();

  // See Sink::check_name().
  Result<void> check_name() const { return sink_->check_name(); }

  bool chunk_is_empty() const { return chunk_.empty(); }
  size_t chunk_bytes() const { return chunk_.size(); }
  uint64_t file_bytes() const { return position_; }  // without the open chunk
  uint64_t messages() const { return statistics_.messages; }
  uint64_t chunks() const { return chunk_indexes_.size(); }

 private:
  Writer(std::unique_ptr<Sink> sink, const WriterOptions& options)
      : sink_(std::move(sink)), options_(options) {}

  // Appends all of `record` or nothing.
  Result<void> append_whole(std::span<const std::byte> record);
  void count(const ChunkHead& head);

  std::unique_ptr<Sink> sink_;
  WriterOptions options_;
  Compressor compressor_;
  uint64_t position_ = 0;
  uint32_t data_crc_ = 0;  // over all bytes of the file

  Bytes chunk_;  // records of the open chunk
  uint64_t chunk_start_ns_ = 0, chunk_end_ns_ = 0;
  std::map<uint16_t, MessageIndex> chunk_messages_;  // by channel; retained to reuse their memory
  Bytes record_;

  std::vector<Schema> schemas_;
  std::vector<Channel> channels_;
  std::vector<ChunkIndex> chunk_indexes_;
  std::vector<AttachmentIndex> attachments_;
  std::vector<MetadataIndex> metadata_;
  Statistics statistics_;
};

}  // namespace fire3dv::record
