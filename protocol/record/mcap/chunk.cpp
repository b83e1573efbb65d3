#include "protocol/record/mcap/chunk.h"

#include <algorithm>

#include "protocol/record/mcap/crc32.h"
#include "protocol/wire/check.h"

namespace fire3dv::record {
namespace {

std::string place_of(const Source& source, const RecordAt& record) {
  return wire::printable(source.name(), 4096) + ": the chunk at byte " + std::to_string(record.offset);
}

bool belongs_into_chunk(Kind kind) {
  // Ignores record kinds of later format versions.
  return kind == Kind::schema || kind == Kind::channel || kind == Kind::message || kind > Kind::data_end;
}

}  // namespace

Result<ChunkHead> read_chunk_head(Source& source, const RecordAt& record) {
  std::array<std::byte, kMaxChunkHead> bytes;
  const auto there =
      std::span(bytes).first(static_cast<size_t>(std::min<uint64_t>(kMaxChunkHead, record.content_bytes())));
  if (auto good = source.read(record.content_at(), there); !good) return good.error();
  ChunkHead head;
  if (!parse(there, head)) return Error{place_of(source, record) + " has no sound head; it is skipped"};
  const uint64_t head_bytes = 8 + 8 + 8 + 4 + 4 + head.compression.size() + 8;
  if (head.compressed_bytes != record.content_bytes() - head_bytes)
    return Error{place_of(source, record) + " states another length than it has; it is skipped"};
  return head;
}

Result<void> ChunkReader::load(Source& source, const RecordAt& record) {
  at_ = 0;
  records_.clear();
  auto head = read_chunk_head(source, record);
  if (!head) return head.error();
  head_ = std::move(*head);
  const std::string where = place_of(source, record);
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

}  // namespace fire3dv::record
