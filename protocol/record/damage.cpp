#include "protocol/record/damage.h"

#include <algorithm>
#include <map>
#include <optional>

#include "protocol/record/mcap/bytes.h"
#include "protocol/wire/check.h"

namespace fire3dv::record {
namespace {

constexpr size_t kMaxProblems = 100;

class Verifier {
 public:
  explicit Verifier(Reader& reader) : reader_(reader), source_(reader.source()) {}
  Result<Report> run(const std::function<void(const Message&)>& on_message);

 private:
  void problem(std::string text) {
    ++report_.problem_count;
    if (report_.problems.size() < kMaxProblems) report_.problems.push_back(std::move(text));
  }
  void take_messages(const std::function<void(const Message&)>& on_message);
  void end_chunk(const ChunkIndex& chunk);
  Result<void> check_message_indexes(const ChunkIndex& chunk);
  Result<void> check_data_crc();
  void check_summary();
  Result<void> check_attachments();

  Reader& reader_;
  Source& source_;
  Report report_;
  Statistics counted_;
  FileIndex seen_;  // from the scan of every record, to compare with the reader's index
  // Messages of the current chunk.
  std::map<uint16_t, MessageIndex> chunk_messages_;
};

Result<Report> Verifier::run(const std::function<void(const Message&)>& on_message) {
  auto seen = scan(source_, reader_.limits());
  if (!seen) return seen.error();
  seen_ = std::move(*seen);
  if (!seen_.damage.empty()) problem(seen_.damage);
  if (const std::string& damage = reader_.index().damage; !damage.empty() && damage != seen_.damage)
    problem(damage);
  take_messages(on_message);
  for (const ChunkIndex& chunk : seen_.chunks)
    if (auto good = check_message_indexes(chunk); !good) return good.error();
  if (auto good = check_data_crc(); !good) return good.error();
  if (auto good = check_attachments(); !good) return good.error();
  const std::optional<Statistics>& stated = reader_.index().statistics;
  if (reader_.index().has_summary)
    check_summary();
  else if (stated && stated->messages != counted_.messages)
    problem("the summary counts " + std::to_string(stated->messages) + " messages; there are " +
            std::to_string(counted_.messages));
  report_.messages = counted_.messages;
  report_.chunks = reader_.index().chunks.size();
  report_.attachments = seen_.attachments.size();
  report_.metadata = seen_.metadata.size();
  return std::move(report_);
}

void Verifier::take_messages(const std::function<void(const Message&)>& on_message) {
  reader_.rewind();
  Message message;
  for (;;) {
    const Reader::Step step = reader_.next(message);
    if (step == Reader::Step::end) return;
    if (step == Reader::Step::damaged) {
      ++report_.damaged_chunks;
      problem(reader_.problem());
      continue;
    }
    const ChunkIndex& chunk = reader_.index().chunks[reader_.chunk()];
    if (message.log_time_ns < chunk.start_ns || message.log_time_ns > chunk.end_ns)
      problem("a message of the chunk at byte " + std::to_string(chunk.offset) +
              " lies outside of the chunk's times");
    counted_.start_ns =
        counted_.messages == 0 ? message.log_time_ns : std::min(counted_.start_ns, message.log_time_ns);
    counted_.end_ns = std::max(counted_.end_ns, message.log_time_ns);
    ++counted_.messages;
    ++counted_.messages_of_channel[message.channel_id];
    on_message(message);
  }
}

Result<void> Verifier::check_message_indexes(const ChunkIndex& chunk) {
  if (chunk.message_indexes.empty() || chunk.loose) return {};  // message indexes are optional
  ChunkReader unpacked(reader_.limits().max_chunk_bytes());
  if (!unpacked.load(source_, {Kind::chunk, chunk.offset, chunk.length})) return {};  // reported already
  chunk_messages_.clear();
  while (const auto entry = unpacked.next()) {
    Message message;
    if (entry->kind != Kind::message || !parse(entry->content, message)) continue;
    MessageIndex& index = chunk_messages_[message.channel_id];
    index.channel_id = message.channel_id;
    index.entries.emplace_back(message.log_time_ns, entry->offset);
  }
  Bytes content;
  for (const auto& [channel, offset] : chunk.message_indexes) {
    const auto record = RecordIterator(source_, offset, source_.size()).next();
    if (!record) return record.error();
    MessageIndex stated;
    const bool read =
        *record && read_content(source_, **record, kMaxDefinitionBytes, content) && parse(content, stated);
    std::sort(stated.entries.begin(), stated.entries.end());
    MessageIndex& counted = chunk_messages_[channel];
    std::sort(counted.entries.begin(), counted.entries.end());
    // An empty index may refer to a channel without messages in the chunk.
    counted.channel_id = channel;
    if (!read || stated != counted)
      problem("the index of messages at byte " + std::to_string(offset) + " is not that of its chunk");
    chunk_messages_.erase(channel);
  }
  if (!chunk_messages_.empty())
    problem("the chunk at byte " + std::to_string(chunk.offset) + " has messages that no index lists");
  return {};
}

Result<void> Verifier::check_data_crc() {
  BufferedSource buffered(source_);
  RecordIterator walker(buffered, kMagic.size(), source_.size());
  Bytes content;
  for (;;) {
    const auto record = walker.next();
    if (!record) return record.error();
    if (!*record) return {};  // truncation is reported already
    if ((*record)->kind != Kind::data_end) continue;
    uint32_t stated = 0, crc = 0;
    if ((*record)->content_bytes() < 4 || !read_content(source_, **record, kMaxDefinitionBytes, content) ||
        !Parser(content).get(stated)) {
      problem("the end of the data is damaged");
      return {};
    }
    report_.data_crc_given = stated != 0;
    if (stated == 0) return {};
    for (uint64_t at = 0; at < (*record)->offset; at += content.size()) {
      content.resize(static_cast<size_t>(std::min<uint64_t>((*record)->offset - at, 1 << 20)));
      if (auto good = source_.read(at, content); !good) return good;
      crc = crc32(content, crc);
    }
    if (crc != stated) problem("the check sum over all data is wrong");
    return {};
  }
}

void Verifier::check_summary() {
  const FileIndex& stated = reader_.index();
  if (stated.schemas != seen_.schemas || stated.channels != seen_.channels) {
    // Foreign files may define channels inside chunks, which scan() skips; the reader then has both.
    for (const auto& [id, channel] : seen_.channels)
      if (const auto known = stated.channels.find(id);
          known == stated.channels.end() || known->second != channel)
        problem("channel " + std::to_string(id) + " is another one in the summary");
    for (const auto& [id, schema] : seen_.schemas)
      if (const auto known = stated.schemas.find(id);
          known == stated.schemas.end() || known->second != schema)
        problem("schema " + std::to_string(id) + " is another one in the summary");
  }
  std::vector<ChunkIndex> chunks = seen_.chunks, stated_chunks = stated.chunks;
  for (ChunkIndex& chunk : chunks) std::sort(chunk.message_indexes.begin(), chunk.message_indexes.end());
  std::sort(stated_chunks.begin(), stated_chunks.end(),
            [](const auto& a, const auto& b) { return a.offset < b.offset; });
  if (stated_chunks.size() != chunks.size())
    problem("the summary lists " + std::to_string(stated_chunks.size()) + " chunks; there are " +
            std::to_string(chunks.size()));
  else
    for (size_t i = 0; i < chunks.size(); ++i)
      if (stated_chunks[i] != chunks[i])
        problem("the summary's entry of the chunk at byte " + std::to_string(chunks[i].offset) + " is wrong");
  if (stated.attachments != seen_.attachments) problem("the summary lists other attachments than there are");
  if (stated.metadata != seen_.metadata) problem("the summary lists other metadata than there are");
  if (!stated.statistics) return;
  Statistics counted = counted_;
  counted.schemas = static_cast<uint16_t>(stated.schemas.size());
  counted.channels = static_cast<uint32_t>(stated.channels.size());
  counted.attachments = static_cast<uint32_t>(seen_.attachments.size());
  counted.metadata = static_cast<uint32_t>(seen_.metadata.size());
  counted.chunks = static_cast<uint32_t>(seen_.chunks.size());
  Statistics given = *stated.statistics;
  std::erase_if(given.messages_of_channel, [](const auto& channel) { return channel.second == 0; });
  if (given != counted) problem("the statistics in the summary are not those of the file");
}

Result<void> Verifier::check_attachments() {
  for (const AttachmentIndex& attachment : seen_.attachments)
    if (auto good = reader_.read_attachment(attachment, [](auto) { return Result<void>(); }); !good)
      problem(good.error().message);
  return {};
}

}  // namespace

Result<Report> verify(Reader& reader, const std::function<void(const Message&)>& on_message) {
  return Verifier(reader).run(on_message);
}

namespace {

// Source over the data of an attachment, for copying in pieces. Attachments are not compressed.
class AttachmentData final : public Source {
 public:
  AttachmentData(Source& file, const AttachmentIndex& index) : file_(file), index_(index) {}
  uint64_t size() const override { return index_.data_bytes; }
  const std::string& name() const override { return file_.name(); }
  Result<void> read(uint64_t offset, std::span<std::byte> to) override {
    return file_.read(index_.offset + index_.length - 4 - index_.data_bytes + offset, to);
  }

 private:
  Source& file_;
  const AttachmentIndex& index_;
};

class Recovery {
 public:
  Recovery(Reader& reader, Writer writer, const std::function<void(size_t, size_t)>& on_chunk)
      : reader_(reader), writer_(std::move(writer)), on_chunk_(on_chunk) {}
  Result<Recovered> run();

 private:
  Result<void> copy_messages();
  Result<void> copy_attachments();
  Result<void> copy_metadata();
  Result<uint16_t> channel_of(uint16_t id);
  void note(const std::string& damage) {
    if (result_.first_damage.empty()) result_.first_damage = damage;
  }

  Reader& reader_;
  Writer writer_;
  const std::function<void(size_t chunk, size_t chunks)>& on_chunk_;
  Recovered result_;
  std::map<uint16_t, uint16_t> channels_, schemas_;  // old id to new id
};

Result<Recovered> Recovery::run() {
  note(reader_.index().damage);
  if (auto good = copy_attachments(); !good) return good.error();
  if (auto good = copy_metadata(); !good) return good.error();
  if (auto good = copy_messages(); !good) return good.error();
  if (result_.messages == 0 && result_.attachments == 0) return std::move(result_);  // no file of nothing
  if (auto good = writer_.finish(); !good) return good.error();
  return std::move(result_);
}

Result<uint16_t> Recovery::channel_of(uint16_t id) {
  if (const auto known = channels_.find(id); known != channels_.end()) return known->second;
  const Channel& channel = reader_.index().channels.at(id);
  uint16_t schema_id = 0;
  if (channel.schema_id != 0) {
    const Schema& schema = reader_.index().schemas.at(channel.schema_id);
    const auto [known, is_new] = schemas_.try_emplace(channel.schema_id, uint16_t{0});
    if (is_new) {
      const auto added = writer_.add_schema(schema.name, schema.encoding, schema.data);
      if (!added) return added.error();
      known->second = *added;
    }
    schema_id = known->second;
  }
  const auto added =
      writer_.add_channel(schema_id, channel.topic, channel.message_encoding, channel.metadata);
  if (!added) return added.error();
  channels_[id] = *added;
  return *added;
}

Result<void> Recovery::copy_messages() {
  Message message;
  std::optional<size_t> chunk;
  reader_.rewind();  // the reader may stand anywhere
  for (;;) {
    const Reader::Step step = reader_.next(message);
    if (step == Reader::Step::end) return {};
    if (step == Reader::Step::damaged) {
      ++result_.damaged_chunks;
      note(reader_.problem());
      continue;
    }
    // Preserves the chunk boundaries, so that players can seek as before. Chunks that overlap in time
    // alternate.
    if (!chunk || reader_.chunk() > *chunk) {
      if (auto good = writer_.end_chunk(); !good) return good;
      chunk = reader_.chunk();
      if (on_chunk_) on_chunk_(*chunk, reader_.index().chunks.size());
      ++result_.chunks;
    }
    const auto channel = channel_of(message.channel_id);
    if (!channel) return channel.error();
    message.channel_id = *channel;
    if (auto good = writer_.write(message); !good) return good;
    ++result_.messages;
  }
}

Result<void> Recovery::copy_attachments() {
  for (const AttachmentIndex& attachment : reader_.index().attachments) {
    if (auto whole = reader_.read_attachment(attachment, [](auto) { return Result<void>(); }); !whole) {
      ++result_.damaged_attachments;
      note(whole.error().message);
      continue;
    }
    AttachmentData data(reader_.source(), attachment);
    if (auto good = writer_.attach(attachment, data); !good) return good;
    ++result_.attachments;
  }
  return {};
}

Result<void> Recovery::copy_metadata() {
  Bytes content;
  for (const MetadataIndex& index : reader_.index().metadata) {
    if (index.offset > reader_.source().size()) continue;
    const auto record = RecordIterator(reader_.source(), index.offset, reader_.source().size()).next();
    if (!record) return record.error();
    Metadata metadata;
    if (!*record || (*record)->kind != Kind::metadata ||
        !read_content(reader_.source(), **record, kMaxDefinitionBytes, content) ||
        !parse(content, metadata)) {
      note("metadata at byte " + std::to_string(index.offset) + " is damaged");
      continue;
    }
    if (auto good = writer_.add_metadata(metadata); !good) return good;
  }
  return {};
}

}  // namespace

Result<Recovered> recover(Reader& reader, std::unique_ptr<Sink> sink, const WriterOptions& options,
                          const std::function<void(size_t chunk, size_t chunks)>& on_chunk) {
  auto writer = Writer::open(std::move(sink), options);
  if (!writer) return writer.error();
  return Recovery(reader, std::move(*writer), on_chunk).run();
}

}  // namespace fire3dv::record
