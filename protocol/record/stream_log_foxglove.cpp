// Channels of StreamLog with Foxglove's schemas.
#include <utility>

#include "protocol/record/channels.h"
#include "protocol/record/stream_log.h"

namespace fire3dv::record {
namespace {

// Of point clouds, in one file: each marker of points has a channel, and readers hold all channels.
constexpr size_t kMaxCloudChannels = 256;

}  // namespace

Result<uint16_t> StreamLog::schema_of(uint16_t& known, std::string_view name,
                                      std::span<const std::byte> schema) {
  if (known != 0) return known;
  const auto added = writer_->add_schema(std::string(name), std::string(kEncoding), schema);
  if (added) known = *added;
  return added;
}

Result<void> StreamLog::write_foxglove(uint16_t channel, uint32_t sequence, uint64_t publish_time_ns,
                                       std::span<const std::byte> message) {
  if (writer_->chunk_is_empty()) {
    chunk_begun_ns_ = now_ns_;
    chunk_has_snapshots_ = false;
  }
  ++file_messages_;
  auto good = writer_->write({channel, sequence, now_ns_, publish_time_ns, message});
  account_closed_chunk();
  return good;
}

Result<void> StreamLog::write_transforms(Stream& stream, const wire::PoseFrameView& frame,
                                         uint64_t publish_time_ns) {
  const std::span<const std::byte> message = stream.transforms.encode(frame, now_ns_);
  if (message.empty()) return {};
  if (stream.transforms_channel == 0) {
    const auto schema = schema_of(transforms_schema_, kTransformsSchema, transforms_schema());
    if (!schema) return schema.error();
    const auto known = channel_of(stream.seen.name, kRoles.size(), *schema, "transforms");
    if (!known) return known.error();
    stream.transforms_channel = *known;
  }
  return write_foxglove(stream.transforms_channel, static_cast<uint32_t>(frame.header.sequence),
                        publish_time_ns, message);
}

Result<void> StreamLog::write_models() {
  const auto schema = schema_of(scene_schema_, kSceneUpdateSchema, scene_update_schema());
  if (!schema) return schema.error();
  const auto channel = writer_->add_channel(*schema, "/scene", std::string(kEncoding), {});
  if (!channel) return channel.error();
  const Bytes message = scene_update(options_.models, now_ns_);
  chunk_begun_ns_ = now_ns_;
  ++file_messages_;
  if (auto good = writer_->write({*channel, 0, now_ns_, now_ns_, message}); !good) return good;
  return writer_->end_chunk();  // large messages get a chunk of their own
}

// Without a value if the file has no room for another channel.
Result<std::optional<uint16_t>> StreamLog::cloud_channel_of(Stream& stream, const std::string& marker) {
  const std::string topic = "/" + stream.seen.name + "/points/" + marker;
  if (const auto known = cloud_channels_.find(topic); known != cloud_channels_.end())
    return std::optional<uint16_t>(known->second);
  if (cloud_channels_.size() == kMaxCloudChannels) return std::optional<uint16_t>();
  const auto schema = schema_of(cloud_schema_, kPointCloudSchema, point_cloud_schema());
  if (!schema) return schema.error();
  const auto added = writer_->add_channel(*schema, topic, std::string(kEncoding), {});
  if (!added) return added.error();
  channel_bytes_ += kChannelOverhead + 2 * topic.size();
  cloud_channels_[topic] = *added;
  return std::optional<uint16_t>(*added);
}

Result<void> StreamLog::write_markers(Stream& stream, const std::vector<FoxgloveMessage>& messages) {
  for (const FoxgloveMessage& message : messages) {
    uint16_t channel = stream.markers_channel;
    if (!message.cloud.empty()) {
      const auto known = cloud_channel_of(stream, message.cloud);
      if (!known) return known.error();
      if (!*known) {
        stream.markers.count_left_out();
        continue;
      }
      channel = **known;
    } else if (channel == 0) {
      const auto schema = schema_of(scene_schema_, kSceneUpdateSchema, scene_update_schema());
      if (!schema) return schema.error();
      const auto known = channel_of(stream.seen.name, kRoles.size() + 1, *schema, "markers");
      if (!known) return known.error();
      channel = stream.markers_channel = *known;
    }
    if (auto good = write_foxglove(channel, 0, now_ns_, message.data); !good) return good;
  }
  return {};
}

Result<void> StreamLog::write_marker(Stream& stream, const wire::SceneEdit& edit) {
  const auto* marker = std::get_if<wire::Marker>(&edit.value);
  return write_markers(stream, marker != nullptr ? stream.markers.set(edit.node, *marker, now_ns_)
                                                 : stream.markers.clear(edit.node, now_ns_));
}

// At the start of a file, whose viewers know nothing of earlier ones.
Result<void> StreamLog::write_all_markers(Stream& stream) {
  for (const auto& [key, stored] : stream.edits) {
    if (key.second != wire::Property::marker) continue;
    const auto decoded = snapshot_decoder_.decode(stored.second);
    const auto* edit = decoded ? std::get_if<wire::SceneEdit>(&*decoded) : nullptr;
    if (edit == nullptr || std::holds_alternative<wire::Cleared>(edit->value)) continue;
    if (auto good = write_marker(stream, *edit); !good) return good;
  }
  return {};
}

uint64_t StreamLog::unconverted_markers() const {
  uint64_t count = reclaimed_unconverted_;
  for (const auto& stream : streams_) count += stream->markers.left_out();
  return count;
}

}  // namespace fire3dv::record
