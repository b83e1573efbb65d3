#include "protocol/record/mcap/record_iterator.h"

#include <algorithm>
#include <array>

#include "protocol/wire/check.h"

namespace fire3dv::record {

Result<std::optional<RecordAt>> RecordIterator::next() {
  if (at_ > until_ || until_ - at_ < kRecordHead) return std::optional<RecordAt>();
  std::array<std::byte, kRecordHead> head;
  if (auto good = source_->read(at_, head); !good) return good.error();
  Parser parser(head);
  uint8_t kind = 0;
  uint64_t length = 0;
  parser.get(kind);
  parser.get(length);
  if (kind == 0 || length > until_ - at_ - kRecordHead) return std::optional<RecordAt>();
  const RecordAt record{static_cast<Kind>(kind), at_, kRecordHead + length};
  at_ = record.end();
  return std::optional<RecordAt>(record);
}

Result<void> BufferedSource::read(uint64_t offset, std::span<std::byte> to) {
  constexpr uint64_t kWindowBytes = 256 << 10;
  const auto has = [&] {
    return offset >= window_at_ && offset - window_at_ <= window_.size() &&
           to.size() <= window_.size() - (offset - window_at_);
  };
  if (!has()) {
    if (to.size() >= kWindowBytes || offset >= source_.size()) return source_.read(offset, to);
    window_.resize(static_cast<size_t>(std::min(kWindowBytes, source_.size() - offset)));
    window_at_ = offset;
    if (auto good = source_.read(offset, window_); !good) {
      window_.clear();
      return good;
    }
    if (!has()) return source_.read(offset, to);
  }
  std::copy_n(window_.begin() + static_cast<std::ptrdiff_t>(offset - window_at_), to.size(), to.begin());
  return {};
}

Result<void> read_content(Source& source, const RecordAt& record, uint64_t most, Bytes& content) {
  if (record.content_bytes() > most)
    return Error{wire::printable(source.name(), 4096) + ": a record at byte " +
                 std::to_string(record.offset) + " has " + std::to_string(record.content_bytes()) +
                 " bytes; of this kind at most " + std::to_string(most) + " are read"};
  content.resize(static_cast<size_t>(record.content_bytes()));
  return source.read(record.content_at(), content);
}

Result<void> check_magic(Source& source) {
  std::array<std::byte, kMagic.size()> magic{};
  const bool long_enough = source.size() >= magic.size();
  if (long_enough)
    if (auto good = source.read(0, magic); !good) return good;
  for (size_t i = 0; i < magic.size(); ++i)
    if (!long_enough || static_cast<uint8_t>(magic[i]) != kMagic[i])
      return Error{wire::printable(source.name(), 4096) + " is not an MCAP file; name a recording"};
  return {};
}

}  // namespace fire3dv::record
