// MCAP reader: uses the summary if it is valid, otherwise scans the file for intact records. Messages come in
// file order, which is log-time order in our recordings. Damaged chunks are skipped and reported. Memory
// stays within the limit, regardless of the file's contents.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "protocol/base/error.h"
#include "protocol/record/mcap/chunk.h"
#include "protocol/record/mcap/summary.h"

namespace fire3dv::record {

class Reader {
 public:
  // Fails for a file that is no MCAP file, or if the memory limit is too small for it.
  static Result<Reader> open(std::unique_ptr<Source> source, const ReadLimits& limits = {});

  const FileIndex& index() const { return index_; }
  const std::string& name() const { return source_->name(); }
  Source& source() { return *source_; }
  const ReadLimits& limits() const { return limits_; }

  // The next message is the first one at or after this time, in file order.
  void seek(uint64_t log_time_ns);
  // Seeks to the beginning of one of index().chunks. alone: reading ends with that chunk.
  void seek_chunk(size_t chunk, bool alone = false);

  enum class Step { message, damaged, end };
  // damaged: problem() describes the skipped part, and reading can continue. The message is valid until the
  // next call.
  Step next(Message& message);
  const std::string& problem() const { return problem_; }
  // Chunk of the message that next() returned last.
  size_t chunk() const { return next_chunk_ - 1; }

  // Passes the attachment to on_piece in pieces. The result reports a wrong CRC.
  Result<void> read_attachment(const AttachmentIndex& index,
                               const std::function<Result<void>(std::span<const std::byte>)>& on_piece);

 private:
  Reader(std::unique_ptr<Source> source, const ReadLimits& limits)
      : source_(std::move(source)), limits_(limits), chunk_(limits.max_chunk_bytes()) {}

  Result<void> define(const ChunkReader::Entry& entry);

  std::unique_ptr<Source> source_;
  ReadLimits limits_;
  FileIndex index_;
  ChunkReader chunk_;
  size_t next_chunk_ = 0, until_chunk_ = SIZE_MAX;
  std::optional<size_t> loaded_;  // chunk that chunk_ holds: a seek reads one chunk several times
  uint64_t from_ns_ = 0;
  std::string problem_;
};

}  // namespace fire3dv::record
