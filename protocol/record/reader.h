// Reads a recording: by its summary where that is sound, else by what is whole of it. Messages come in the
// order of the file, which in recordings of ours is that of their log times. What is damaged is passed over
// and said, a chunk at a time; nothing that a file says makes the reader take more memory than it was given.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "protocol/error.h"
#include "protocol/record/chunk.h"
#include "protocol/record/summary.h"

namespace fire3dv::record {

class Reader {
 public:
  // An error for a file that is no MCAP file at all, or that this much memory does not do for.
  static Result<Reader> open(std::unique_ptr<Source> source, const ReadLimits& limits = {});

  const FileIndex& index() const { return index_; }
  const std::string& name() const { return source_->name(); }
  Source& source() { return *source_; }
  const ReadLimits& limits() const { return limits_; }

  // The first message that next() gives is the first one from this time on, in the order of the file.
  void seek(uint64_t log_time_ns);
  // To the beginning of one of index().chunks. alone: what comes ends with that chunk.
  void seek_chunk(size_t chunk, bool alone = false);

  enum class Step { message, damaged, end };
  // damaged: problem() says what was passed over; going on is fine. The message is valid until the next call.
  Step next(Message& message);
  const std::string& problem() const { return problem_; }
  // Of the message that next() gave last.
  size_t chunk() const { return next_chunk_ - 1; }

  // Hands the attachment on in pieces; the last answer says whether its check sum was right.
  Result<void> read_attachment(const AttachmentIndex& index,
                               const std::function<Result<void>(std::span<const std::byte>)>& on_piece);

 private:
  Reader(std::unique_ptr<Source> source, const ReadLimits& limits)
      : source_(std::move(source)), limits_(limits), chunk_(limits.most_chunk_bytes()) {}

  Result<void> define(const ChunkReader::Entry& entry);

  std::unique_ptr<Source> source_;
  ReadLimits limits_;
  FileIndex index_;
  ChunkReader chunk_;
  size_t next_chunk_ = 0, until_chunk_ = SIZE_MAX;
  std::optional<size_t> loaded_;  // what chunk_ holds: seeks look at one chunk several times
  uint64_t from_ns_ = 0;
  std::string problem_;
};

}  // namespace fire3dv::record
