// Sequential iteration over the records of a file. Reads record headers only, which suffices to find a
// truncation.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "protocol/base/error.h"
#include "protocol/record/mcap/file.h"
#include "protocol/record/mcap/records.h"

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

}  // namespace fire3dv::record
