#include "protocol/record/mcap/reader.h"

#include <algorithm>
#include <array>

#include "protocol/record/mcap/bytes.h"
#include "protocol/wire/check.h"

namespace fire3dv::record {
namespace {

std::string location_text(const Source& source, const RecordAt& record) {
  return wire::printable(source.name(), 4096) + ": the chunk at byte " + std::to_string(record.offset);
}

bool belongs_into_chunk(Kind kind) {
  // Ignores record kinds of later format versions.
  return kind == Kind::schema || kind == Kind::channel || kind == Kind::message || kind > Kind::data_end;
}

}  // namespace

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

Result<ChunkHead> read_chunk_head(Source& source, const RecordAt& record) {
  std::array<std::byte, kMaxChunkHead> bytes;
  const auto there =
      std::span(bytes).first(static_cast<size_t>(std::min<uint64_t>(kMaxChunkHead, record.content_bytes())));
  if (auto good = source.read(record.content_at(), there); !good) return good.error();
  ChunkHead head;
  if (!parse(there, head)) return Error{location_text(source, record) + " has no sound head; it is skipped"};
  const uint64_t head_bytes = 8 + 8 + 8 + 4 + 4 + head.compression.size() + 8;
  if (head.compressed_bytes != record.content_bytes() - head_bytes)
    return Error{location_text(source, record) + " states another length than it has; it is skipped"};
  return head;
}

Result<void> ChunkReader::load(Source& source, const RecordAt& record) {
  at_ = 0;
  records_.clear();
  auto head = read_chunk_head(source, record);
  if (!head) return head.error();
  head_ = std::move(*head);
  const std::string where = location_text(source, record);
  const auto compression = compression_of(head_.compression);
  if (!compression)
    return Error{where + " is packed with \"" + wire::printable(head_.compression) +
                 "\"; only zstd, lz4 and none are read"};
  if (head_.uncompressed_bytes > max_bytes_)
    return Error{where + " unpacks to " + std::to_string(head_.uncompressed_bytes) + " bytes, and at most " +
                 std::to_string(max_bytes_) + " are taken; raise --memory-mb if you trust the file"};
  if (head_.compressed_bytes > max_compressed_bytes(head_.uncompressed_bytes))
    return Error{where + " is longer packed than unpacked; it is skipped"};
  const auto unpacked_bytes = static_cast<size_t>(head_.uncompressed_bytes);
  const uint64_t packed_at = record.end() - head_.compressed_bytes;
  if (*compression == Compression::none) {
    if (head_.compressed_bytes != head_.uncompressed_bytes)
      return Error{where + " states two lengths; it is skipped"};
    records_.resize(unpacked_bytes);
    if (auto good = source.read(packed_at, records_); !good) return good;
  } else {
    packed_.clear();  // clear first: otherwise growth would copy the old bytes and allocate more than needed
    packed_.resize(static_cast<size_t>(head_.compressed_bytes));
    if (auto good = source.read(packed_at, packed_); !good) return good;
    records_.resize(unpacked_bytes);
    if (auto good = compressor_.decompress(*compression, packed_, records_); !good) {
      records_.clear();
      return Error{where + " is damaged: " + good.error().message + "; it is skipped"};
    }
  }
  Result<void> good;
  if (head_.uncompressed_crc != 0 && crc32(records_) != head_.uncompressed_crc)
    good = Error{where + " is damaged: its check sum is wrong; it is skipped"};
  if (good) good = check_records(where);
  if (!good) records_.clear();
  return good;
}

Result<void> ChunkReader::check_records(const std::string& where) const {
  Parser parser(records_);
  while (!parser.rest().empty()) {
    uint8_t kind = 0;
    uint64_t length = 0;
    std::span<const std::byte> content;
    if (!parser.get(kind) || !parser.get(length) || !parser.get(length, content))
      return Error{where + " ends inside a record; it is skipped"};
    if (!belongs_into_chunk(static_cast<Kind>(kind)))
      return Error{where + " holds a record of kind " + std::to_string(kind) +
                   ", which does not belong into a chunk; it is skipped"};
    if (static_cast<Kind>(kind) == Kind::message && content.size() < kMessageHead)
      return Error{where + " holds half a message; it is skipped"};
  }
  return {};
}

std::optional<ChunkReader::Entry> ChunkReader::next() {
  while (at_ < records_.size()) {
    const uint64_t offset = at_;
    Parser parser(std::span<const std::byte>(records_).subspan(at_));
    uint8_t kind = 0;
    uint64_t length = 0;
    std::span<const std::byte> content;
    FIRE3DV_ASSERT(parser.get(kind) && parser.get(length) && parser.get(length, content));
    at_ += kRecordHead + static_cast<size_t>(length);
    if (static_cast<Kind>(kind) <= Kind::message) return Entry{static_cast<Kind>(kind), offset, content};
  }
  return std::nullopt;
}

Result<Reader> Reader::open(std::unique_ptr<Source> source, const ReadLimits& limits) {
  if (auto good = check_magic(*source); !good) return good.error();
  Reader reader(std::move(source), limits);
  auto index = read_summary(*reader.source_, limits);
  if (index) {
    reader.index_ = std::move(*index);
    return reader;
  }
  auto scanned = scan(*reader.source_, limits);
  if (!scanned) return Error{wire::printable(reader.name(), 4096) + ": " + scanned.error().message};
  reader.index_ = std::move(*scanned);
  if (reader.index_.damage.empty()) reader.index_.damage = index.error().message;
  return reader;
}

void Reader::seek(uint64_t log_time_ns) {
  const auto& chunks = index_.chunks;
  const auto first = std::find_if(chunks.begin(), chunks.end(),
                                  [&](const ChunkIndex& chunk) { return chunk.end_ns >= log_time_ns; });
  seek_chunk(static_cast<size_t>(first - chunks.begin()));
  from_ns_ = log_time_ns;
}

void Reader::seek_chunk(size_t chunk, bool alone) {
  chunk_.unload();
  next_chunk_ = chunk;
  until_chunk_ = alone ? chunk + 1 : SIZE_MAX;
  from_ns_ = 0;
}

Result<void> Reader::define(const ChunkReader::Entry& entry) {
  const Error damaged{wire::printable(name(), 4096) + ": a chunk defines something that cannot be read"};
  if (entry.content.size() > kMaxDefinitionBytes) return damaged;
  if (entry.kind == Kind::schema) {
    Schema schema;
    return parse(entry.content, schema) ? index_.define(std::move(schema), limits_) : Result<void>(damaged);
  }
  Channel channel;
  return parse(entry.content, channel) ? index_.define(std::move(channel), limits_) : Result<void>(damaged);
}

Reader::Step Reader::next(Message& message) {
  for (;;) {
    while (const auto entry = chunk_.next()) {
      if (entry->kind != Kind::message) {
        if (auto good = define(*entry); !good) {
          problem_ = good.error().message;
          return Step::damaged;
        }
        continue;
      }
      parse(entry->content, message);  // cannot fail: ChunkReader checked the length
      if (message.log_time_ns < from_ns_) continue;
      if (!index_.channels.contains(message.channel_id)) {
        problem_ = wire::printable(name(), 4096) + ": a message is of channel " +
                   std::to_string(message.channel_id) + ", which nothing describes; it is skipped";
        return Step::damaged;
      }
      return Step::message;
    }
    if (next_chunk_ >= std::min(index_.chunks.size(), until_chunk_)) return Step::end;
    if (loaded_ == next_chunk_) {
      ++next_chunk_;
      chunk_.rewind();
      continue;
    }
    loaded_.reset();
    const ChunkIndex& chunk = index_.chunks[next_chunk_++];
    const RecordAt record{Kind::chunk, chunk.offset, chunk.length};
    Result<void> good;
    // The index may be wrong if it has no CRC: the record at this offset must match it.
    std::array<std::byte, kRecordHead> head;
    good = source_->read(record.offset, head);
    if (good) {
      Parser parser(head);
      uint8_t kind = 0;
      uint64_t length = 0;
      parser.get(kind);
      parser.get(length);
      if (kind != static_cast<uint8_t>(Kind::chunk) || length != record.content_bytes())
        good = Error{wire::printable(name(), 4096) + ": the summary lists a chunk at byte " +
                     std::to_string(record.offset) + ", but there is none; it is skipped"};
    }
    if (good) good = chunk_.load(*source_, record);
    if (!good) {
      chunk_.unload();
      problem_ = good.error().message;
      return Step::damaged;
    }
    loaded_ = next_chunk_ - 1;
  }
}

}  // namespace fire3dv::record
