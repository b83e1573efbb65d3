// Reader of MCAP files, and its parts: iteration over the records of a file and over those of a chunk. The
// reader uses the summary if it is valid, otherwise scans the file for intact records. Messages come in
// file order, which is log-time order in our recordings. Damaged chunks are skipped and reported. Memory
// stays within the limit, regardless of the file's contents.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "base/error.h"
#include "protocol/record/mcap/bytes.h"
#include "protocol/record/mcap/file.h"
#include "protocol/record/mcap/records.h"
#include "protocol/record/mcap/summary.h"

namespace fire3dv::record {

// Limit for a definition, an index entry or a metadata record. Honest ones have some kilobytes.
constexpr uint64_t kMaxDefinitionBytes = uint64_t{8} << 20;

struct RecordAt {
  Kind kind{};
  uint64_t offset = 0;  // of the record header
  uint64_t length = 0;  // including the header
  uint64_t content_at() const { return offset + kRecordHead; }
  uint64_t content_bytes() const { return length - kRecordHead; }
  uint64_t end() const { return offset + length; }
};

// Sequential iteration over the records of a file. Reads record headers only, which suffices to find a
// truncation.
class RecordIterator {
 public:
  // Iterates from a record header up to `until`.
  RecordIterator(Source& source, uint64_t from, uint64_t until)
      : source_(&source), at_(from), until_(until) {}

  // The next complete record; nothing after the last one. Fails only if the disk cannot be read.
  Result<std::optional<RecordAt>> next();
  // Offset of the next record, and whether an incomplete record is there.
  uint64_t at() const { return at_; }
  bool cut() const { return at_ < until_; }

 private:
  Source* source_;
  uint64_t at_, until_;
};

// Read-ahead buffer for many small sequential reads.
class BufferedSource final : public Source {
 public:
  explicit BufferedSource(Source& source) : source_(source) {}
  uint64_t size() const override { return source_.size(); }
  const std::string& name() const override { return source_.name(); }
  Result<void> read(uint64_t offset, std::span<std::byte> to) override;

 private:
  Source& source_;
  Bytes window_;
  uint64_t window_at_ = 0;
};

// Reads the content of a record of at most `most` bytes.
Result<void> read_content(Source& source, const RecordAt& record, uint64_t most, Bytes& content);

// Checks the magic bytes: fails for a file that is no recording.
Result<void> check_magic(Source& source);

// Reads the fields that precede the compressed bytes of a chunk.
Result<ChunkHead> read_chunk_head(Source& source, const RecordAt& record);

// Reusable chunk decoder: decompresses one chunk, verifies it, and iterates over its records. Memory: twice
// the longest chunk.
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
