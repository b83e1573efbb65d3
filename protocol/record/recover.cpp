#include "protocol/record/recover.h"

#include <algorithm>
#include <map>
#include <optional>

namespace fire3dv::record {
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
  Recovery(Reader& reader, Writer writer) : reader_(reader), writer_(std::move(writer)) {}
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
  Recovered result_;
  std::map<uint16_t, uint16_t> channels_, schemas_;  // old id to new id
};

Result<Recovered> Recovery::run() {
  note(reader_.index().damage);
  if (auto good = copy_attachments(); !good) return good.error();
  if (auto good = copy_metadata(); !good) return good.error();
  if (auto good = copy_messages(); !good) return good.error();
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
  reader_.seek_chunk(0);  // the reader may stand anywhere
  for (;;) {
    const Reader::Step step = reader_.next(message);
    if (step == Reader::Step::end) return {};
    if (step == Reader::Step::damaged) {
      ++result_.damaged_chunks;
      note(reader_.problem());
      continue;
    }
    // Preserves the chunk boundaries, so that players can seek as before.
    if (chunk != reader_.chunk()) {
      if (auto good = writer_.end_chunk(); !good) return good;
      chunk = reader_.chunk();
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

Result<Recovered> recover(Reader& reader, std::unique_ptr<Sink> sink, const WriterOptions& options) {
  auto writer = Writer::open(std::move(sink), options);
  if (!writer) return writer.error();
  return Recovery(reader, std::move(*writer)).run();
}

}  // namespace fire3dv::record
