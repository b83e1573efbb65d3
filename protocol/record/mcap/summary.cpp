#include "protocol/record/mcap/summary.h"

#include <algorithm>
#include <array>

#include "protocol/record/mcap/bytes.h"
#include "protocol/record/mcap/reader.h"
#include "protocol/wire/check.h"

namespace fire3dv::record {
namespace {

constexpr uint64_t kDataEndBytes = 4;
// Limit on records that are scanned a second time because damage moved the scan back. Only a crafted file
// exceeds it; from then on only chunks and their indexes are followed behind damage.
constexpr uint64_t kMaxPassedAgain = 1 << 18;
constexpr uint64_t kRescanCost = 64;          // cost in records: the buffered data is read again
constexpr uint64_t kMaxLooseBytes = 1 << 20;  // of a range of records outside chunks
constexpr uint64_t kOverhead = 128;           // per entry of a map or vector, in addition to its contents

Error no_summary(const Source& source, const std::string& why) {
  return Error{wire::printable(source.name(), 4096) + ": " + why};
}

uint64_t memory_of(const Texts& texts) {
  uint64_t sum = 0;
  for (const auto& [key, value] : texts) sum += key.size() + value.size() + kOverhead;
  return sum;
}

template <typename Record>
Result<void> parse_into(Source& source, const RecordAt& at, std::span<const std::byte> content,
                        Record& record) {
  if (parse(content, record)) return {};
  return no_summary(source, "the record at byte " + std::to_string(at.offset) + " is damaged");
}

// Validates the chunk index: chunks lie inside the file and do not overlap. An index therefore cannot send a
// reader in circles.
Result<void> check_chunks(const Source& source, std::vector<ChunkIndex>& chunks, uint64_t data_end) {
  std::sort(chunks.begin(), chunks.end(), [](const auto& a, const auto& b) { return a.offset < b.offset; });
  uint64_t free_from = kMagic.size();
  for (const ChunkIndex& chunk : chunks) {
    if (chunk.offset < free_from || chunk.offset > data_end || chunk.length < kRecordHead ||
        chunk.length > data_end - chunk.offset || !compression_of(chunk.compression) ||
        chunk.start_ns > chunk.end_ns)
      return no_summary(source, "its summary names a chunk where none can be");
    free_from = chunk.offset + chunk.length;
  }
  return {};
}

struct Unlisted {
  bool chunks = false;
  uint64_t messages = 0;
};

// Looks for chunks and messages where the summary lists none: between its chunks, before and behind them.
// Reads record headers only.
Result<Unlisted> find_unlisted(Source& source, const std::vector<ChunkIndex>& chunks, uint64_t data_end) {
  Unlisted found;
  const Error differs = no_summary(source, "its summary does not match the data");
  uint64_t at = kMagic.size();
  for (size_t i = 0; i <= chunks.size(); ++i) {
    const uint64_t until = i < chunks.size() ? chunks[i].offset : data_end;
    if (at > until) return differs;
    RecordIterator walker(source, at, until);
    for (;;) {
      const auto record = walker.next();
      if (!record) return record.error();
      if (!*record) break;
      found.messages += (*record)->kind == Kind::message ? 1 : 0;
      found.chunks = found.chunks || (*record)->kind == Kind::chunk;
    }
    if (walker.cut()) return differs;
    if (i == chunks.size()) break;
    const uint64_t end = chunks[i].offset + chunks[i].length;  // check_chunks bounds it
    if (chunks[i].message_index_bytes > data_end - end) return differs;
    at = end + chunks[i].message_index_bytes;
  }
  return found;
}

// Messages that the indexes of all chunks list; nullopt: a chunk has no index.
Result<std::optional<uint64_t>> count_indexed(Source& source, const std::vector<ChunkIndex>& chunks) {
  constexpr uint64_t kIndexHead = 2 + 4, kIndexEntry = 8 + 8;  // channel, bytes of the list; time, offset
  uint64_t count = 0;
  for (const ChunkIndex& chunk : chunks) {
    if (chunk.message_indexes.empty()) return std::optional<uint64_t>();
    for (const auto& [channel, offset] : chunk.message_indexes) {
      if (offset >= source.size()) return std::optional<uint64_t>();
      const auto record = RecordIterator(source, offset, source.size()).next();
      if (!record) return record.error();
      if (!*record || (*record)->kind != Kind::message_index) return std::optional<uint64_t>();
      const uint64_t bytes = (*record)->content_bytes();
      count += bytes > kIndexHead ? (bytes - kIndexHead) / kIndexEntry : 0;
    }
  }
  return std::optional(count);
}

Result<void> take_summary_record(Source& source, const RecordAt& at, std::span<const std::byte> content,
                                 const ReadLimits& limits, FileIndex& index) {
  const auto add = [&](auto& list, auto record, uint64_t bytes) -> Result<void> {
    if (auto good = parse_into(source, at, content, record); !good) return good;
    if (auto good = index.take_memory(kOverhead + bytes, limits); !good) return good;
    list.push_back(std::move(record));
    return {};
  };
  switch (at.kind) {
    case Kind::schema: {
      Schema schema;
      if (auto good = parse_into(source, at, content, schema); !good) return good;
      return index.define(std::move(schema), limits);
    }
    case Kind::channel: {
      Channel channel;
      if (auto good = parse_into(source, at, content, channel); !good) return good;
      return index.define(std::move(channel), limits);
    }
    case Kind::chunk_index:
      return add(index.chunks, ChunkIndex{}, content.size() * 2);
    case Kind::attachment_index:
      return add(index.attachments, AttachmentIndex{}, content.size());
    case Kind::metadata_index:
      return add(index.metadata, MetadataIndex{}, content.size());
    case Kind::statistics: {
      Statistics statistics;
      if (auto good = parse_into(source, at, content, statistics); !good) return good;
      index.statistics = std::move(statistics);
      return index.take_memory(content.size() * 8, limits);
    }
    default:
      return {};  // offset records, which we do not need, and kinds of later versions
  }
}

}  // namespace

Result<void> FileIndex::take_memory(uint64_t bytes, const ReadLimits& limits) {
  memory_ += bytes;
  if (memory_ <= limits.max_index_bytes()) return {};
  return Error{"its index takes more than the " + std::to_string(limits.max_index_bytes() >> 20) +
               " MiB that are reserved for it; raise --memory-mb if you trust the file"};
}

Result<void> FileIndex::define(Schema schema, const ReadLimits& limits) {
  const auto known = schemas.find(schema.id);
  if (known != schemas.end())
    return known->second == schema
               ? Result<void>()
               : Result<void>(Error{"schema " + std::to_string(schema.id) + " has two meanings"});
  if (auto good =
          take_memory(schema.data.size() + schema.name.size() + schema.encoding.size() + kOverhead, limits);
      !good)
    return good;
  const uint16_t id = schema.id;
  schemas.emplace(id, std::move(schema));
  return {};
}

Result<void> FileIndex::define(Channel channel, const ReadLimits& limits) {
  const auto known = channels.find(channel.id);
  if (known != channels.end())
    return known->second == channel
               ? Result<void>()
               : Result<void>(Error{"channel " + std::to_string(channel.id) + " has two meanings"});
  if (channel.schema_id != 0 && !schemas.contains(channel.schema_id))
    return Error{"channel " + std::to_string(channel.id) + " is of a schema that is not there"};
  if (auto good = take_memory(
          memory_of(channel.metadata) + channel.topic.size() + channel.message_encoding.size() + kOverhead,
          limits);
      !good)
    return good;
  const uint16_t id = channel.id;
  channels.emplace(id, std::move(channel));
  return {};
}

Result<Footer> read_footer(Source& source) {
  const uint64_t tail_bytes = kFooterBytes + kMagic.size();
  if (source.size() < kMagic.size() + tail_bytes) return no_summary(source, "it has no footer: it was cut");
  const uint64_t footer_at = source.size() - tail_bytes;
  std::array<std::byte, kFooterBytes + kMagic.size()> tail;
  if (auto good = source.read(footer_at, tail); !good) return good.error();
  for (size_t i = 0; i < kMagic.size(); ++i)
    if (static_cast<uint8_t>(tail[kFooterBytes + i]) != kMagic[i])
      return no_summary(source, "it has no footer: it was cut");
  Parser parser(tail);
  uint8_t kind = 0;
  uint64_t length = 0;
  parser.get(kind);
  parser.get(length);
  Footer footer;
  parse(parser.rest(), footer);
  if (kind != static_cast<uint8_t>(Kind::footer) || length != kFooterBytes - kRecordHead)
    return no_summary(source, "its footer is damaged");
  if (footer.summary_start == 0) return footer;
  const bool offsets_sound =
      footer.summary_offset_start == 0 ||
      (footer.summary_offset_start >= footer.summary_start && footer.summary_offset_start <= footer_at);
  if (footer.summary_start < kMagic.size() || footer.summary_start > footer_at || !offsets_sound)
    return no_summary(source, "its footer is damaged");
  if (footer.summary_crc == 0) return footer;
  uint32_t crc = 0;
  Bytes piece;
  const uint64_t until = source.size() - kMagic.size() - 4;
  for (uint64_t at = footer.summary_start; at < until; at += piece.size()) {
    piece.resize(static_cast<size_t>(std::min<uint64_t>(until - at, 1 << 20)));
    if (auto good = source.read(at, piece); !good) return good.error();
    crc = crc32(piece, crc);
  }
  if (crc != footer.summary_crc) return no_summary(source, "its summary is damaged: the check sum is wrong");
  return footer;
}

Result<FileIndex> read_summary(Source& source, const ReadLimits& limits) {
  const auto footer = read_footer(source);
  if (!footer) return footer.error();
  FileIndex index;
  if (footer->summary_start == 0) {
    index.remark = "it has no summary";
    return index;
  }
  const uint64_t until = footer->summary_offset_start != 0 ? footer->summary_offset_start
                                                           : source.size() - kMagic.size() - kFooterBytes;
  BufferedSource buffered(source);
  RecordIterator walker(buffered, footer->summary_start, until);
  Bytes content;
  for (;;) {
    const auto record = walker.next();
    if (!record) return record.error();
    if (!*record) break;
    if (auto good = read_content(buffered, **record, kMaxDefinitionBytes, content); !good)
      return good.error();
    if (auto good = take_summary_record(source, **record, content, limits, index); !good) return good.error();
  }
  if (walker.cut()) return no_summary(source, "its summary is damaged");
  if (auto good = check_chunks(source, index.chunks, footer->summary_start); !good) return good.error();
  const auto unlisted = find_unlisted(buffered, index.chunks, footer->summary_start);
  if (!unlisted) return unlisted.error();
  if (unlisted->messages > 0) {
    const auto indexed = count_indexed(buffered, index.chunks);
    if (!indexed) return indexed.error();
    // Records outside of chunks have no check sum of their own: a damaged definition may look like a message.
    if (*indexed && index.statistics && **indexed >= index.statistics->messages)
      index.damage = "records outside of its chunks look like " + std::to_string(unlisted->messages) +
                     " messages, which its summary does not count: they are damaged, and left out";
    else
      index.remark = "it has messages outside of chunks";
  }
  if (unlisted->chunks) index.remark = "its summary has no index of chunks";
  if (unlisted->chunks && !index.chunks.empty())
    return no_summary(source, "its summary lists " + std::to_string(index.chunks.size()) +
                                  " chunks, and there are more in the data");
  index.has_summary = index.remark.empty();
  return index;
}

namespace {

// Finds the next plausible chunk at or after `from`, to resume after damage.
Result<std::optional<uint64_t>> find_chunk(Source& source, BufferedSource& buffered, uint64_t from) {
  // kind, length, times, sizes, CRC and compression name
  constexpr uint64_t kLook = kRecordHead + 8 + 8 + 8 + 4;
  Bytes piece;
  uint64_t piece_bytes = 4 << 10;  // starts small: the next chunk is often near
  for (uint64_t at = from; at + kLook < source.size(); at += piece.size() - kLook) {
    piece.resize(static_cast<size_t>(std::min(source.size() - at, piece_bytes)));
    piece_bytes = std::min<uint64_t>(2 * piece_bytes, 1 << 20);
    if (auto good = source.read(at, piece); !good) return good.error();
    for (size_t i = 0; i + kLook < piece.size(); ++i) {
      if (piece[i] != static_cast<std::byte>(Kind::chunk)) continue;
      uint64_t length = 0;
      Parser(std::span<const std::byte>(piece).subspan(i + 1)).get(length);
      if (length > source.size() - at - i - kRecordHead) continue;
      const auto head = read_chunk_head(buffered, {Kind::chunk, at + i, kRecordHead + length});
      if (head && compression_of(head->compression)) return std::optional<uint64_t>(at + i);
    }
    if (at + piece.size() == source.size()) break;
  }
  return std::optional<uint64_t>();
}

class Scan {
 public:
  Scan(Source& source, const ReadLimits& limits)
      : source_(source),
        buffered_(source),
        limits_(limits),
        walker_(buffered_, kMagic.size(), source.size()) {}

  Result<FileIndex> run() {
    for (;;) {
      const auto record = walker_.next();
      if (!record) return record.error();
      // Checks the length, too: a record with a damaged kind must not end the scan.
      if (*record && (*record)->kind == Kind::data_end && (*record)->content_bytes() == kDataEndBytes)
        return std::move(index_);
      const bool follows = *record && known((*record)->kind) && follow(**record);
      if (follows) {
        auto sound = take(**record);
        if (!sound) return sound.error();
        if (*sound) continue;
      }
      note("the record at byte " + std::to_string(*record ? (*record)->offset : walker_.at()) +
           " is not whole: it was cut or damaged, or is still being written; fire3dv-record recover makes a "
           "whole file of it");
      const auto chunk = find_chunk(source_, buffered_, search_from_);
      if (!chunk) return chunk.error();
      if (!*chunk) return std::move(index_);
      if (**chunk < passed_) rescanned_records_ += kRescanCost;
      walker_ = RecordIterator(buffered_, **chunk, source_.size());
      search_from_ = **chunk + 1;
    }
  }

 private:
  static bool known(Kind kind) {
    return kind != Kind::footer && (kind <= Kind::data_end || static_cast<uint8_t>(kind) >= 0x80);
  }
  bool follow(const RecordAt& record) {
    if (record.offset >= passed_)
      passed_ = record.end();
    else
      ++rescanned_records_;
    return rescanned_records_ <= kMaxPassedAgain || record.kind == Kind::chunk ||
           record.kind == Kind::message_index;
  }
  void note(std::string text) {
    if (index_.damage.empty()) index_.damage = std::move(text);
  }

  // Returns false if the content contradicts the record kind.
  Result<bool> take(const RecordAt& record) {
    switch (record.kind) {
      case Kind::schema:
      case Kind::channel:
      case Kind::metadata: {
        if (record.content_bytes() > kMaxDefinitionBytes) return false;
        if (auto good = read_content(buffered_, record, kMaxDefinitionBytes, content_); !good)
          return good.error();
        if (record.kind == Kind::metadata) {
          Metadata metadata;
          if (!parse(content_, metadata)) return false;
          index_.metadata.push_back({record.offset, record.length, metadata.name});
          return charge(sizeof(MetadataIndex) + metadata.name.size());
        }
        if (auto good = take_summary_record(source_, record, content_, limits_, index_); !good)
          note(good.error().message);
        if (follows_loose(record)) extend(record.length);
        return true;
      }
      case Kind::message:
        return take_loose(record);
      case Kind::chunk: {
        const auto head = read_chunk_head(buffered_, record);
        if (!head) return false;
        search_from_ = record.end();
        index_.chunks.push_back({head->start_ns,
                                 head->end_ns,
                                 record.offset,
                                 record.length,
                                 {},
                                 0,
                                 head->compression,
                                 head->compressed_bytes,
                                 head->uncompressed_bytes});
        return charge(sizeof(ChunkIndex) + kOverhead);
      }
      case Kind::message_index: {
        std::array<std::byte, 2> id;
        if (index_.chunks.empty() || index_.chunks.back().loose || record.content_bytes() < id.size())
          return false;
        if (auto good = buffered_.read(record.content_at(), id); !good) return good.error();
        uint16_t channel = 0;
        Parser(id).get(channel);
        ChunkIndex& chunk = index_.chunks.back();
        chunk.message_indexes.emplace_back(channel, record.offset);
        chunk.message_index_bytes += record.length;
        return charge(2 * sizeof(chunk.message_indexes[0]));
      }
      case Kind::attachment: {
        auto attachment = read_attachment_head(buffered_, record);
        if (!attachment) return false;
        const uint64_t named_bytes = attachment->name.size() + attachment->media_type.size();
        index_.attachments.push_back(std::move(*attachment));
        return charge(sizeof(AttachmentIndex) + kOverhead + named_bytes);
      }
      case Kind::data_end:
        return false;
      default:
        return true;
    }
  }
  bool follows_loose(const RecordAt& record) const {
    if (index_.chunks.empty()) return false;
    const ChunkIndex& last = index_.chunks.back();
    return last.loose && last.offset + last.length == record.offset &&
           last.length + record.length <= std::min(kMaxLooseBytes, limits_.max_chunk_bytes());
  }
  void extend(uint64_t bytes) {
    ChunkIndex& range = index_.chunks.back();
    range.length += bytes;
    range.compressed_bytes = range.uncompressed_bytes = range.length;
  }
  Result<bool> take_loose(const RecordAt& record) {
    std::array<std::byte, kMessageHead> head;
    if (record.content_bytes() < head.size()) return false;
    if (auto good = buffered_.read(record.content_at(), head); !good) return good.error();
    Message message;
    if (!parse(head, message)) return false;
    uint64_t taken = 0;
    if (!follows_loose(record)) {
      index_.chunks.emplace_back();
      index_.chunks.back().offset = record.offset;
      index_.chunks.back().start_ns = message.log_time_ns;
      index_.chunks.back().loose = true;
      taken += sizeof(ChunkIndex) + kOverhead;
    }
    extend(record.length);
    ChunkIndex& range = index_.chunks.back();
    range.start_ns = std::min(range.start_ns, message.log_time_ns);
    range.end_ns = std::max(range.end_ns, message.log_time_ns);
    const auto at = std::lower_bound(range.message_indexes.begin(), range.message_indexes.end(),
                                     std::pair(message.channel_id, uint64_t{0}));
    if (at == range.message_indexes.end() || at->first != message.channel_id) {
      range.message_indexes.emplace(at, message.channel_id, record.offset);
      taken += 2 * sizeof(range.message_indexes[0]);
    }
    return charge(taken);
  }
  Result<bool> charge(uint64_t bytes) {
    if (auto good = index_.take_memory(bytes, limits_); !good) return good.error();
    return true;
  }

  Source& source_;
  BufferedSource buffered_;
  ReadLimits limits_;
  FileIndex index_;
  RecordIterator walker_;
  Bytes content_;
  uint64_t search_from_ = kMagic.size();
  uint64_t passed_ = 0;             // end of the scanned records
  uint64_t rescanned_records_ = 0;  // number of records scanned again before passed_
};

}  // namespace

Result<FileIndex> scan(Source& source, const ReadLimits& limits) {
  return Scan(source, limits).run();
}

}  // namespace fire3dv::record
