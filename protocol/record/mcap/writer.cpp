#include "protocol/record/mcap/writer.h"

#include <algorithm>

namespace fire3dv::record {
namespace {

constexpr const char* kProfile = "fire3dv";
constexpr const char* kLibrary = "fire3dv";
constexpr size_t kMaxDefinitions = 65'535;  // ids have 16 bits

}  // namespace

Result<Writer> Writer::open(std::unique_ptr<Sink> sink, const WriterOptions& options) {
  Writer writer(std::move(sink), options);
  Bytes head;
  put(head, std::as_bytes(std::span(kMagic)));
  append_header(head, kProfile, kLibrary);
  if (auto good = writer.append_whole(head); !good) return good.error();
  return writer;
}

Result<void> Writer::append_whole(std::span<const std::byte> record) {
  if (auto good = sink_->append(record); !good) {
    // Best effort: readers skip a partial record as well.
    (void)sink_->truncate(position_).ok();
    return good;
  }
  position_ += record.size();
  data_crc_ = crc32(record, data_crc_);
  return {};
}

Result<uint16_t> Writer::add_schema(const std::string& name, const std::string& encoding,
                                    std::span<const std::byte> data) {
  if (schemas_.size() == kMaxDefinitions)
    return Error{sink_->name() + " holds as many schemas as a file can"};
  Schema schema{static_cast<uint16_t>(schemas_.size() + 1), name, encoding, Bytes(data.begin(), data.end())};
  record_.clear();
  append(record_, schema);
  if (auto good = append_whole(record_); !good) return good.error();
  schemas_.push_back(std::move(schema));
  return schemas_.back().id;
}

Result<uint16_t> Writer::add_channel(uint16_t schema_id, const std::string& topic,
                                     const std::string& message_encoding, const Texts& metadata) {
  if (channels_.size() == kMaxDefinitions)
    return Error{sink_->name() + " holds as many channels as a file can; record fewer streams into it"};
  Channel channel{static_cast<uint16_t>(channels_.size() + 1), schema_id, topic, message_encoding, metadata};
  record_.clear();
  append(record_, channel);
  if (auto good = append_whole(record_); !good) return good.error();
  channels_.push_back(std::move(channel));
  return channels_.back().id;
}

Result<void> Writer::write(const Message& message) {
  FIRE3DV_ASSERT(message.channel_id >= 1 && message.channel_id <= channels_.size());
  if (chunk_.empty()) chunk_start_ns_ = chunk_end_ns_ = message.log_time_ns;
  chunk_start_ns_ = std::min(chunk_start_ns_, message.log_time_ns);
  chunk_end_ns_ = std::max(chunk_end_ns_, message.log_time_ns);
  MessageIndex& index = chunk_messages_[message.channel_id];
  index.channel_id = message.channel_id;
  index.entries.emplace_back(message.log_time_ns, chunk_.size());
  append(chunk_, message);
  return chunk_.size() >= options_.chunk_bytes ? end_chunk() : Result<void>();
}

void Writer::count(const ChunkHead& head) {
  Statistics& all = statistics_;
  for (const auto& [channel, index] : chunk_messages_) {
    if (index.entries.empty()) continue;
    all.messages += index.entries.size();
    all.messages_of_channel[channel] += index.entries.size();
  }
  all.start_ns = chunk_indexes_.empty() ? head.start_ns : std::min(all.start_ns, head.start_ns);
  all.end_ns = std::max(all.end_ns, head.end_ns);
}

Result<void> Writer::end_chunk() {
  if (chunk_.empty()) return {};
  ChunkHead head{chunk_start_ns_, chunk_end_ns_, chunk_.size(), crc32(chunk_), {}, 0};
  // The head's length depends on the compression, so the compressed bytes come first and the head is inserted
  // before them.
  Bytes packed;
  Compression used = options_.compression;
  if (!compressor_.compress(used, chunk_, packed)) used = Compression::none;
  const std::span<const std::byte> content =
      used == Compression::none ? std::span<const std::byte>(chunk_) : packed;
  head.compression = compression_name(used);
  head.compressed_bytes = content.size();
  record_.clear();
  append(record_, head);
  put(record_, content);

  ChunkIndex index{head.start_ns,
                   head.end_ns,
                   position_,
                   record_.size(),
                   {},
                   0,
                   head.compression,
                   head.compressed_bytes,
                   head.uncompressed_bytes};
  for (const auto& [channel, messages] : chunk_messages_) {
    if (messages.entries.empty()) continue;
    index.message_indexes.emplace_back(channel, position_ + record_.size());
    append(record_, messages);
  }
  index.message_index_bytes = record_.size() - index.length;

  const Result<void> good = append_whole(record_);
  if (good) {
    count(head);
    chunk_indexes_.push_back(std::move(index));
  }
  chunk_.clear();
  for (auto& [channel, messages] : chunk_messages_) messages.entries.clear();
  return good;
}

Result<void> Writer::flush() {
  if (auto good = end_chunk(); !good) return good;
  return sink_->flush();
}

Result<void> Writer::add_metadata(const Metadata& metadata) {
  record_.clear();
  append(record_, metadata);
  const MetadataIndex index{position_, record_.size(), metadata.name};
  if (auto good = append_whole(record_); !good) return good;
  metadata_.push_back(index);
  return {};
}

Result<void> Writer::finish() {
  Result<void> good = end_chunk();
  const uint64_t whole_until = position_;
  record_.clear();
  append_data_end(record_, data_crc_);
  if (auto ended = append_whole(record_); !ended) {
    (void)sink_->flush().ok();  // flushes the complete chunks
    return good ? ended : good;
  }

  statistics_.schemas = static_cast<uint16_t>(schemas_.size());
  statistics_.channels = static_cast<uint32_t>(channels_.size());
  statistics_.attachments = static_cast<uint32_t>(attachments_.size());
  statistics_.metadata = static_cast<uint32_t>(metadata_.size());
  statistics_.chunks = static_cast<uint32_t>(chunk_indexes_.size());
  Bytes summary, offsets;
  const auto group = [&](Kind kind, const auto& records) {
    const size_t start = summary.size();
    for (const auto& record : records) append(summary, record);
    if (summary.size() != start)
      append_summary_offset(offsets, kind, position_ + start, summary.size() - start);
  };
  group(Kind::schema, schemas_);
  group(Kind::channel, channels_);
  group(Kind::statistics, std::array{statistics_});
  group(Kind::chunk_index, chunk_indexes_);
  group(Kind::attachment_index, attachments_);
  group(Kind::metadata_index, metadata_);
  Footer footer{position_, position_ + summary.size(), 0};
  put(summary, std::span<const std::byte>(offsets));
  put(summary, static_cast<uint8_t>(Kind::footer));
  put(summary, kFooterBytes - kRecordHead);
  put(summary, footer.summary_start);
  put(summary, footer.summary_offset_start);
  put(summary, crc32(summary));
  put(summary, std::as_bytes(std::span(kMagic)));
  if (auto ended = append_whole(summary); !ended) {
    (void)sink_->truncate(whole_until).ok();
    (void)sink_->flush().ok();  // flushes the complete chunks
    return good ? ended : good;
  }
  const Result<void> finished = sink_->finish();
  return good ? finished : good;
}

}  // namespace fire3dv::record
