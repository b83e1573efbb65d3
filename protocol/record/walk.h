// Passes over the records of a file one after the other, from the front. Knows their lengths, not their
// contents: that is enough to find where a file was cut.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "protocol/error.h"
#include "protocol/record/file.h"
#include "protocol/record/records.h"

namespace fire3dv::record {

// Of a definition, an index entry or a metadata record. An honest one has some kilobytes.
constexpr uint64_t kMostDefinitionBytes = uint64_t{8} << 20;

struct RecordAt {
  Kind kind{};
  uint64_t offset = 0;  // of the record's head
  uint64_t length = 0;  // with its head
  uint64_t content_at() const { return offset + kRecordHead; }
  uint64_t content_bytes() const { return length - kRecordHead; }
  uint64_t end() const { return offset + length; }
};

class Walker {
 public:
  // From one record's head up to `until`.
  Walker(Source& source, uint64_t from, uint64_t until) : source_(&source), at_(from), until_(until) {}

  // The next record that is whole, nothing behind the last one. An error only for a disk that cannot be read.
  Result<std::optional<RecordAt>> next();
  // Where the next record would stand, and whether something stands there that is not a whole record.
  uint64_t at() const { return at_; }
  bool cut() const { return at_ < until_; }

 private:
  Source* source_;
  uint64_t at_, until_;
};

// Reads ahead, for many small reads that follow one another.
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

// The content of a record that is not longer than `most` bytes.
Result<void> read_content(Source& source, const RecordAt& record, uint64_t most, Bytes& content);

// Checks the magic bytes at the front: else it is no recording at all.
Result<void> check_magic(Source& source);

}  // namespace fire3dv::record
