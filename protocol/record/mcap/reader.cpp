#include "protocol/record/mcap/reader.h"

#include <algorithm>
#include <array>
#include <queue>
#include <ranges>
#include <utility>

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
  order_.clear();
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

Result<void> ChunkReader::load_loose(Source& source, const RecordAt& range) {
  at_ = 0;
  records_.clear();
  order_.clear();
  const std::string where =
      wire::printable(source.name(), 4096) + ": the message at byte " + std::to_string(range.offset);
  if (range.length > max_bytes_)
    return Error{where + " has " + std::to_string(range.length) + " bytes, and at most " +
                 std::to_string(max_bytes_) + " are taken; raise --memory-mb if you trust the file"};
  records_.resize(static_cast<size_t>(range.length));
  Result<void> good = source.read(range.offset, records_);
  if (good) good = check_records(where);
  if (!good) records_.clear();
  return good;
}

Result<void> ChunkReader::check_records(const std::string& where) {
  Parser parser(records_);
  uint64_t newest_ns = 0;
  bool is_sorted = true;
  while (!parser.rest().empty()) {
    uint8_t kind = 0;
    uint64_t length = 0;
    std::span<const std::byte> content;
    if (!parser.get(kind) || !parser.get(length) || !parser.get(length, content))
      return Error{where + " ends inside a record; it is skipped"};
    if (!belongs_into_chunk(static_cast<Kind>(kind)))
      return Error{where + " holds a record of kind " + std::to_string(kind) +
                   ", which does not belong into a chunk; it is skipped"};
    if (static_cast<Kind>(kind) != Kind::message) continue;
    Message message;
    if (!parse(content, message)) return Error{where + " holds half a message; it is skipped"};
    is_sorted = is_sorted && message.log_time_ns >= newest_ns;
    newest_ns = message.log_time_ns;
  }
  if (!is_sorted) sort_records();
  return {};
}

// Of records that check_records() has seen.
ChunkReader::Entry ChunkReader::entry_at(size_t offset, size_t& end) const {
  Parser parser(std::span<const std::byte>(records_).subspan(offset));
  uint8_t kind = 0;
  uint64_t length = 0;
  std::span<const std::byte> content;
  FIRE3DV_ASSERT(parser.get(kind) && parser.get(length) && parser.get(length, content));
  end = offset + kRecordHead + static_cast<size_t>(length);
  return {static_cast<Kind>(kind), offset, content};
}

void ChunkReader::sort_records() {
  const auto time_of = [this](size_t offset) {
    size_t end = 0;
    const Entry entry = entry_at(offset, end);
    Message message;
    return entry.kind == Kind::message && parse(entry.content, message) ? message.log_time_ns : 0;
  };
  size_t end = 0;
  for (size_t offset = 0; offset < records_.size(); offset = end) {
    const Entry entry = entry_at(offset, end);
    if (entry.kind <= Kind::message) order_.push_back(offset);
  }
  const auto messages = std::stable_partition(order_.begin(), order_.end(), [&](size_t offset) {
    return entry_at(offset, end).kind != Kind::message;
  });
  std::stable_sort(messages, order_.end(), [&](size_t a, size_t b) { return time_of(a) < time_of(b); });
}

std::optional<ChunkReader::Entry> ChunkReader::next() {
  size_t end = 0;
  if (!order_.empty()) {
    if (at_ >= order_.size()) return std::nullopt;
    return entry_at(order_[at_++], end);
  }
  while (at_ < records_.size()) {
    const Entry entry = entry_at(at_, end);
    at_ = end;
    if (entry.kind <= Kind::message) return entry;
  }
  return std::nullopt;
}

Result<Reader> Reader::open(std::unique_ptr<Source> source, const ReadLimits& limits) {
  if (auto good = check_magic(*source); !good) return good.error();
  Reader reader(std::move(source), limits);
  auto index = read_summary(*reader.source_, limits);
  if (index && index->has_summary) {
    reader.index_ = std::move(*index);
  } else {
    auto scanned = scan(*reader.source_, limits);
    if (!scanned) return Error{wire::printable(reader.name(), 4096) + ": " + scanned.error().message};
    reader.index_ = std::move(*scanned);
    if (!index && reader.index_.damage.empty()) reader.index_.damage = index.error().message;
    if (index) {
      reader.index_.remark = wire::printable(reader.name(), 4096) + ": " + index->remark;
      // Definitions inside of chunks, which scan() does not read. Contradictions are met again there.
      for (auto& [id, schema] : index->schemas) (void)reader.index_.define(std::move(schema), limits);
      for (auto& [id, channel] : index->channels) (void)reader.index_.define(std::move(channel), limits);
      reader.index_.statistics = std::move(index->statistics);
    }
  }
  reader.read_definitions();
  reader.sort_chunks();
  reader.rewind();
  return reader;
}

// Sorts the chunks by time, if those that overlap fit into the memory for chunks together.
void Reader::sort_chunks() {
  constexpr uint64_t kLaneBytes = 256 << 10;  // codec and buffers
  auto& chunks = index_.chunks;
  std::stable_sort(chunks.begin(), chunks.end(),
                   [](const ChunkIndex& a, const ChunkIndex& b) { return a.start_ns < b.start_ns; });
  using End = std::pair<uint64_t, uint64_t>;  // time, bytes
  std::priority_queue<End, std::vector<End>, std::greater<>> open;
  uint64_t bytes = 0, max_bytes = 0;
  for (const ChunkIndex& chunk : chunks) {
    while (!open.empty() && open.top().first <= chunk.start_ns) {
      bytes -= open.top().second;
      open.pop();
    }
    // Larger ones are refused.
    const uint64_t needs = std::min(chunk.uncompressed_bytes, limits_.max_chunk_bytes()) + kLaneBytes;
    open.emplace(chunk.end_ns, needs);
    bytes += needs;
    if (open.size() > 1) max_bytes = std::max(max_bytes, bytes);
  }
  merges_ = max_bytes <= limits_.max_chunk_bytes();
  if (merges_) return;
  std::sort(chunks.begin(), chunks.end(), [](const auto& a, const auto& b) { return a.offset < b.offset; });
  index_.remark += (index_.remark.empty() ? wire::printable(name(), 4096) + ": " : "; ") +
                   std::string("chunks that overlap in time take ") + std::to_string(max_bytes >> 20) +
                   " MiB together, so messages come in file order; raise --memory-mb to " +
                   std::to_string((max_bytes >> 18) + 4) + " to have them in the order of time";
}

// Finds channels that only chunks define. Chunks are read for it only if they may define any.
void Reader::read_definitions() {
  const bool all_known =
      index_.has_summary && index_.statistics && index_.statistics->channels <= index_.channels.size();
  if (all_known) return;
  ChunkReader records(limits_.max_chunk_bytes());
  for (const ChunkIndex& chunk : index_.chunks) {
    const bool is_known =
        !chunk.message_indexes.empty() && std::ranges::all_of(chunk.message_indexes, [&](const auto& entry) {
          return index_.channels.contains(entry.first);
        });
    if (chunk.loose || is_known || !records.load(*source_, {Kind::chunk, chunk.offset, chunk.length}))
      continue;  // damage is reported when the chunk is read
    while (const auto entry = records.next())
      if (entry->kind != Kind::message) (void)define(*entry);
  }
}

void Reader::seek(uint64_t log_time_ns, ChunkFilter wants) {
  while (!lanes_.empty()) close(lanes_.size() - 1);
  behind_.reset();
  next_chunk_ = 0;
  until_chunk_ = SIZE_MAX;
  from_ns_ = log_time_ns;
  wants_ = std::move(wants);
}

void Reader::seek_chunk(size_t chunk) {
  seek(0);
  next_chunk_ = chunk;
  until_chunk_ = chunk + 1;
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

void Reader::close(size_t lane) {
  spare_ = std::move(lanes_[lane]);
  lanes_.erase(lanes_.begin() + static_cast<std::ptrdiff_t>(lane));
}

Result<void> Reader::advance(size_t lane_index) {
  Lane& lane = *lanes_[lane_index];
  while (const auto entry = lane.records.next()) {
    if (entry->kind != Kind::message) {
      if (auto good = define(*entry); !good) return good;
      continue;
    }
    parse(entry->content, lane.next);  // cannot fail: ChunkReader checked the length
    if (lane.next.log_time_ns < from_ns_) continue;
    if (!index_.channels.contains(lane.next.channel_id))
      return Error{wire::printable(name(), 4096) + ": a message is of channel " +
                   std::to_string(lane.next.channel_id) + ", which nothing describes; it is skipped"};
    return {};
  }
  close(lane_index);
  return {};
}

Result<void> Reader::load(Lane& lane, size_t chunk_index) {
  const ChunkIndex& chunk = index_.chunks[chunk_index];
  const RecordAt record{Kind::chunk, chunk.offset, chunk.length};
  if (chunk.loose) return lane.records.load_loose(*source_, record);
  // The index may be wrong if it has no CRC: the record at this offset must match it.
  std::array<std::byte, kRecordHead> head;
  if (auto good = source_->read(record.offset, head); !good) return good;
  Parser parser(head);
  uint8_t kind = 0;
  uint64_t length = 0;
  parser.get(kind);
  parser.get(length);
  if (kind != static_cast<uint8_t>(Kind::chunk) || length != record.content_bytes())
    return Error{wire::printable(name(), 4096) + ": the summary lists a chunk at byte " +
                 std::to_string(record.offset) + ", but there is none; it is skipped"};
  // The memory for chunks that are open together is planned by the index.
  const auto own = read_chunk_head(*source_, record);
  if (own && own->uncompressed_bytes != chunk.uncompressed_bytes)
    return Error{location_text(*source_, record) +
                 " has another size than the summary states; it is skipped"};
  if (auto good = lane.records.load(*source_, record); !good) return good;
  if (!lanes_.empty()) lane.records.release_packed();
  return {};
}

Result<void> Reader::open_chunk(size_t chunk) {
  std::unique_ptr<Lane> lane = std::move(spare_);
  const bool is_loaded = lane && lane->chunk == chunk;
  if (!lane) lane = std::make_unique<Lane>(limits_.max_chunk_bytes());
  if (is_loaded) {
    lane->records.rewind();
  } else {
    lane->chunk = SIZE_MAX;
    if (auto good = load(*lane, chunk); !good) {
      spare_ = std::move(lane);
      return good;
    }
  }
  lane->chunk = chunk;
  lanes_.push_back(std::move(lane));
  behind_ = lanes_.size() - 1;
  return {};
}

size_t Reader::earliest_lane() const {
  size_t earliest = 0;
  const auto key = [&](size_t lane) {
    return std::pair(lanes_[lane]->next.log_time_ns, index_.chunks[lanes_[lane]->chunk].offset);
  };
  for (size_t i = 1; i < lanes_.size(); ++i)
    if (key(i) < key(earliest)) earliest = i;
  return earliest;
}

bool Reader::is_due(const ChunkIndex& chunk, const Lane* earliest) const {
  if (!earliest) return true;
  return merges_ && std::pair(chunk.start_ns, chunk.offset) <
                        std::pair(earliest->next.log_time_ns, index_.chunks[earliest->chunk].offset);
}

Reader::Step Reader::next(Message& message) {
  const auto damaged = [this](const Result<void>& result) {
    problem_ = result.error().message;
    return Step::damaged;
  };
  for (;;) {
    if (behind_) {
      const size_t count = lanes_.size();
      if (auto good = advance(*behind_); !good) return damaged(good);
      if (lanes_.size() == count) last_chunk_ = lanes_[*behind_]->chunk;
      behind_.reset();
    }
    const size_t earliest = lanes_.empty() ? 0 : earliest_lane();
    const Lane* const lane = lanes_.empty() ? nullptr : lanes_[earliest].get();
    while (next_chunk_ < std::min(index_.chunks.size(), until_chunk_) &&
           (index_.chunks[next_chunk_].end_ns < from_ns_ || (wants_ && !wants_(index_.chunks[next_chunk_]))))
      ++next_chunk_;
    const bool has_chunk = next_chunk_ < std::min(index_.chunks.size(), until_chunk_);
    if (has_chunk && is_due(index_.chunks[next_chunk_], lane)) {
      if (auto good = open_chunk(next_chunk_++); !good) return damaged(good);
      continue;
    }
    if (!lane) return Step::end;
    message = lane->next;
    last_chunk_ = lane->chunk;
    behind_ = earliest;
    return Step::message;
  }
}

}  // namespace fire3dv::record
