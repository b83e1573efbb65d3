#include "protocol/record/file_channels.h"

namespace fire3dv::record {
namespace {

constexpr uint64_t kChannelOverhead = 512;

std::string topic_of(const std::string& stream, std::string_view end) {
  return "/" + stream + "/" + std::string(end);
}

}  // namespace

void FileChannels::begin(Writer& writer) {
  *this = {};
  writer_ = &writer;
}

Result<uint16_t> FileChannels::schema(std::string_view name, std::span<const std::byte> data) {
  if (const auto known = schemas_.find(name); known != schemas_.end()) return known->second;
  const auto added = writer_->add_schema(std::string(name), std::string(kEncoding), data);
  if (added) schemas_.emplace(name, *added);
  return added;
}

bool FileChannels::has_channel(const std::string& stream, std::string_view end, uint16_t schema) const {
  return channels_.contains({topic_of(stream, end), schema});
}

Result<uint16_t> FileChannels::channel(const std::string& stream, std::string_view end, uint16_t schema,
                                       const Texts& metadata) {
  const std::string topic = topic_of(stream, end);
  if (const auto known = channels_.find({topic, schema}); known != channels_.end()) return known->second;
  const auto added = writer_->add_channel(schema, topic, std::string(kEncoding), metadata);
  if (!added) return added;
  channels_.emplace(std::pair(topic, schema), *added);
  streams_.insert(stream);
  bytes_ += kChannelOverhead + 2 * topic.size();
  return added;
}

}  // namespace fire3dv::record
