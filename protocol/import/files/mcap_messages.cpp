#include "protocol/import/files/mcap_messages.h"

#include <algorithm>
#include <map>
#include <utility>

#include "protocol/record/mcap/reader.h"

namespace fire3dv::imported {
namespace {

// Chunks with camera images are larger than those of streams.
constexpr uint64_t kReadMemoryBytes = uint64_t{512} << 20;
constexpr size_t kMaxWarnings = 20;  // a damaged file may have any number of chunks

class McapMessages final : public MessageSource {
 public:
  McapMessages(record::Reader reader, ShouldStop should_stop)
      : reader_(std::move(reader)), should_stop_(std::move(should_stop)), name_(reader_.name()) {
    for (const auto& [id, channel] : reader_.index().channels) {
      const auto schema = reader_.index().schemas.find(channel.schema_id);
      topic_of_channel_[id] = topics_.size();
      topics_.push_back({channel.topic, schema == reader_.index().schemas.end() ? "" : schema->second.name,
                         channel.message_encoding});
    }
    const std::string& damage = reader_.index().damage;
    if (!damage.empty()) warnings_.push_back(damage + "; what is whole is read");
  }

  const std::string& name() const override { return name_; }
  const std::vector<Topic>& topics() const override { return topics_; }
  Result<void> rewind(const std::vector<size_t>& topics) override {
    counts_.assign(topics_.size(), 0);
    is_wanted_.assign(topics_.size(), false);
    for (const size_t topic : topics) is_wanted_[topic] = true;
    // A chunk without an index of its channels may have any.
    reader_.seek(0, [this](const record::ChunkIndex& chunk) {
      return chunk.message_indexes.empty() ||
             std::any_of(chunk.message_indexes.begin(), chunk.message_indexes.end(),
                         [this](const auto& each) { return is_wanted(each.first); });
    });
    return {};
  }
  Result<std::optional<SourceMessage>> next() override {
    record::Message message;
    while (true) {
      // Messages of other topics may be many.
      if (should_stop_ && should_stop_()) return Error{"stopped"};
      switch (reader_.next(message)) {
        case record::Reader::Step::end:
          return std::optional<SourceMessage>();
        case record::Reader::Step::damaged:
          if (warnings_.size() < kMaxWarnings) warnings_.push_back(reader_.problem());
          continue;
        case record::Reader::Step::message:
          break;
      }
      if (!is_wanted(message.channel_id)) continue;
      const size_t topic = topic_of_channel_[message.channel_id];
      return std::optional(SourceMessage{topic, message.log_time_ns, ++counts_[topic], message.data});
    }
  }
  double progress() const override {
    const size_t chunks = reader_.index().chunks.size();
    return chunks == 0 ? 1 : static_cast<double>(reader_.chunk()) / static_cast<double>(chunks);
  }
  std::vector<std::string> take_warnings() override { return std::exchange(warnings_, {}); }

 private:
  bool is_wanted(uint16_t channel) const {
    const auto found = topic_of_channel_.find(channel);
    return found != topic_of_channel_.end() && is_wanted_[found->second];
  }

  record::Reader reader_;
  ShouldStop should_stop_;
  std::string name_;
  std::vector<Topic> topics_;
  std::map<uint16_t, size_t> topic_of_channel_;
  std::vector<bool> is_wanted_;
  std::vector<uint64_t> counts_;
  std::vector<std::string> warnings_;
};

}  // namespace

Result<std::unique_ptr<MessageSource>> open_mcap_messages(const std::string& path,
                                                          const ShouldStop& should_stop) {
  auto source = record::open_source(path);
  if (!source) return source.error();
  record::ReadLimits limits;
  limits.memory_bytes = kReadMemoryBytes;
  Result<record::Reader> reader = record::Reader::open(std::move(*source), limits);
  if (!reader) return reader.error();
  return std::unique_ptr<MessageSource>(std::make_unique<McapMessages>(std::move(*reader), should_stop));
}

}  // namespace fire3dv::imported
