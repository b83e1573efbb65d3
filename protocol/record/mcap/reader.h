// Reader of MCAP files, and its parts: iteration over the records of a file and over those of a chunk. The
// reader uses the summary if it is valid and complete, otherwise scans the file for intact records. Messages
// come in log-time order, those of one time in file order; chunks that overlap in time are merged within the
// memory limit. Damaged chunks are skipped and reported. Memory stays within the limit, regardless of the
// file's contents.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

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
  // The same for a range of records outside chunks.
  Result<void> load_loose(Source& source, const RecordAt& range);
  const ChunkHead& head() const { return head_; }
  // Frees what only load() needs.
  void release_packed() { packed_ = Bytes(); }

  struct Entry {
    Kind kind{};
    uint64_t offset = 0;  // offset in the uncompressed chunk
    std::span<const std::byte> content;
  };
  // Schemas, channels and messages in file order, or, where messages are not in log-time order, all
  // definitions and then the messages in that order. The content is valid until the next load().
  std::optional<Entry> next();
  void rewind() { at_ = 0; }

 private:
  Result<void> check_records(const std::string& where);
  void sort_records();
  Entry entry_at(size_t offset, size_t& end) const;

  uint64_t max_bytes_;
  Compressor compressor_;
  ChunkHead head_;
  Bytes packed_, records_;
  std::vector<size_t> order_;  // offsets of records; empty: file order
  size_t at_ = 0;              // index into order_, or offset into records_
};

class Reader {
 public:
  // Fails for a file that is no MCAP file, or if the memory limit is too small for it.
  static Result<Reader> open(std::unique_ptr<Source> source, const ReadLimits& limits = {});

  const FileIndex& index() const { return index_; }
  const std::string& name() const { return source_->name(); }
  Source& source() { return *source_; }
  const ReadLimits& limits() const { return limits_; }

  // The next message is the first one at or after this time. wants: chunks to be read; empty: all.
  using ChunkFilter = std::function<bool(const ChunkIndex&)>;
  void seek(uint64_t log_time_ns, ChunkFilter wants = {});
  // Reads all messages, from the first one on.
  void rewind() { seek(0); }
  // Reads one of index().chunks alone.
  void seek_chunk(size_t chunk);

  enum class Step { message, damaged, end };
  // damaged: problem() describes the skipped part, and reading can continue. The message is valid until the
  // next call.
  Step next(Message& message);
  const std::string& problem() const { return problem_; }
  // Chunk of the message that next() returned last.
  size_t chunk() const { return last_chunk_; }

  // Passes the attachment to on_piece in pieces. The result reports a wrong CRC.
  Result<void> read_attachment(const AttachmentIndex& index,
                               const std::function<Result<void>(std::span<const std::byte>)>& on_piece);

 private:
  // An open chunk. Chunks that overlap in time are open together.
  struct Lane {
    explicit Lane(uint64_t max_bytes) : records(max_bytes) {}
    size_t chunk = 0;  // in the index
    ChunkReader records;
    Message next;
  };

  Reader(std::unique_ptr<Source> source, const ReadLimits& limits)
      : source_(std::move(source)), limits_(limits) {}

  void sort_chunks();
  void read_definitions();
  Result<void> define(const ChunkReader::Entry& entry);
  bool is_due(const ChunkIndex& chunk, const Lane* earliest) const;
  Result<void> open_chunk(size_t chunk);
  Result<void> load(Lane& lane, size_t chunk);
  // Moves a lane to its next message, or closes it at its end. After an error it goes on behind the cause.
  Result<void> advance(size_t lane);
  void close(size_t lane);
  size_t earliest_lane() const;

  std::unique_ptr<Source> source_;
  ReadLimits limits_;
  FileIndex index_;
  bool merges_ = true;  // chunks are open together where they overlap in time
  std::vector<std::unique_ptr<Lane>> lanes_;
  std::unique_ptr<Lane> spare_;   // reused: a seek reads one chunk several times
  std::optional<size_t> behind_;  // lane whose message was returned, or had an error: it is to advance
  size_t next_chunk_ = 0, until_chunk_ = SIZE_MAX, last_chunk_ = 0;
  uint64_t from_ns_ = 0;
  ChunkFilter wants_;
  std::string problem_;
};

}  // namespace fire3dv::record
