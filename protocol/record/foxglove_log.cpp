#include "protocol/record/foxglove_log.h"

#include <variant>

#include "protocol/record/channels.h"

namespace fire3dv::record {
namespace {

// Of point clouds, in one file: each marker of points has a channel, and readers hold all channels.
constexpr size_t kMaxCloudChannels = 256;

// Sets `channel` to that of the stream's messages of this schema, unless it is known.
Result<void> find_channel(FileChannels& channels, uint16_t& channel, const std::string& name,
                          std::string_view end, std::string_view schema_name,
                          std::span<const std::byte> schema_data) {
  if (channel != 0) return {};
  const auto schema = channels.schema(schema_name, schema_data);
  if (!schema) return schema.error();
  const auto known = channels.channel(name, end, *schema);
  if (!known) return known.error();
  channel = *known;
  return {};
}

}  // namespace

Result<void> FoxgloveLog::write_transforms(const Output& output, Stream& stream, const std::string& name,
                                           const wire::PoseFrameView& frame, uint64_t publish_time_ns) {
  const std::span<const std::byte> message = stream.transforms.encode(frame, output.log_time_ns);
  if (message.empty()) return {};
  if (auto good = find_channel(output.channels, stream.transforms_channel, name, "transforms",
                               kTransformsSchema, transforms_schema());
      !good)
    return good;
  return output.write(stream.transforms_channel, static_cast<uint32_t>(frame.header.sequence),
                      publish_time_ns, message);
}

// Without a value if the file has no room for another channel.
Result<std::optional<uint16_t>> FoxgloveLog::cloud_channel(FileChannels& channels, const std::string& name,
                                                           const std::string& marker) {
  const std::string end = "points/" + marker;
  const auto schema = channels.schema(kPointCloudSchema, point_cloud_schema());
  if (!schema) return schema.error();
  const bool is_new = !channels.has_channel(name, end, *schema);
  if (is_new && cloud_channels_ == kMaxCloudChannels) return std::optional<uint16_t>();
  const auto channel = channels.channel(name, end, *schema);
  if (!channel) return channel.error();
  cloud_channels_ += is_new ? 1 : 0;
  return std::optional<uint16_t>(*channel);
}

Result<void> FoxgloveLog::write_markers(const Output& output, Stream& stream, const std::string& name,
                                        const std::vector<FoxgloveMessage>& messages) {
  for (const FoxgloveMessage& message : messages) {
    uint16_t channel = 0;
    if (!message.cloud.empty()) {
      const auto known = cloud_channel(output.channels, name, message.cloud);
      if (!known) return known.error();
      if (!*known) {
        stream.markers.count_left_out();
        continue;
      }
      channel = **known;
    } else {
      if (auto good = find_channel(output.channels, stream.markers_channel, name, "markers",
                                   kSceneUpdateSchema, scene_update_schema());
          !good)
        return good;
      channel = stream.markers_channel;
    }
    if (auto good = output.write(channel, 0, output.log_time_ns, message.data); !good) return good;
  }
  return {};
}

Result<void> FoxgloveLog::write_marker(const Output& output, Stream& stream, const std::string& name,
                                       const wire::SceneEdit& edit) {
  const auto* marker = std::get_if<wire::Marker>(&edit.value);
  return write_markers(output, stream, name,
                       marker != nullptr ? stream.markers.set(edit.node, *marker, output.log_time_ns)
                                         : stream.markers.clear(edit.node, output.log_time_ns));
}

}  // namespace fire3dv::record
