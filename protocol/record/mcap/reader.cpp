#include "protocol/record/mcap/reader.h"

#include <algorithm>

#include "protocol/wire/check.h"

namespace fire3dv::record {

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
