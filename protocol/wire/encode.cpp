#include "protocol/wire/encode.h"

#include <bit>
#include <cstring>

#include "base/error.h"
#include "protocol/wire/encode_tables.h"

// Tables are built field by field, not by the generated Create functions: their field order depends on the
// flatc version, and the bytes must not. Defaults are written as well, so that PoseFrameEncoder can patch
// every field.

namespace fire3dv::wire {
namespace {

static_assert(std::endian::native == std::endian::little,
              "poses are copied to the wire, which is little-endian");
static_assert(sizeof(fbs::Affine3x4) == sizeof(Affine3x4) && sizeof(fbs::Affine3x4d) == sizeof(Affine3x4d));

using flatbuffers::FlatBufferBuilder;
using flatbuffers::Offset;
using Strings = flatbuffers::Vector<Offset<flatbuffers::String>>;

Offset<Strings> add_strings(FlatBufferBuilder& builder, const std::vector<std::string>& texts) {
  std::vector<Offset<flatbuffers::String>> offsets;
  offsets.reserve(texts.size());
  for (const std::string& text : texts) offsets.push_back(builder.CreateString(text));
  return builder.CreateVector(offsets);
}

Offset<flatbuffers::Vector<const fbs::Affine3x4*>> add_poses(FlatBufferBuilder& builder,
                                                             std::span<const Affine3x4> poses) {
  return builder.CreateVectorOfStructs(reinterpret_cast<const fbs::Affine3x4*>(poses.data()), poses.size());
}

// Poses are written first and thus placed last; everything before them is the head.
Bytes build_pose_frame(const PoseFrameView& frame) {
  FlatBufferBuilder builder(256 + frame.poses.size_bytes());
  builder.ForceDefaults(true);
  const auto poses = add_poses(builder, frame.poses);
  const auto indices = frame.node_indices.empty()
                           ? 0
                           : builder.CreateVector(frame.node_indices.data(), frame.node_indices.size());
  fbs::PoseFrameBuilder table(builder);
  // Only if present: older readers reject the field.
  if (!frame.node_indices.empty()) table.add_node_indices(indices);
  table.add_poses(poses);
  table.add_flags(frame.header.flags);
  table.add_node_count(frame.node_count);
  table.add_first_node(frame.first_node);
  table.add_scene_version(frame.header.scene_version);
  table.add_publish_time_ns(frame.header.publish_time_ns);
  table.add_sim_time_ns(frame.header.sim_time_ns);
  table.add_sequence(frame.header.sequence);
  table.add_epoch(frame.header.epoch);
  return finish(builder, fbs::Body::PoseFrame, table.Finish().Union());
}

template <typename T>
void patch(Bytes& bytes, size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
}

}  // namespace

Bytes encode(const StreamDescription& description) {
  FlatBufferBuilder builder(4096);
  builder.ForceDefaults(true);
  const auto boot_id = builder.CreateString(description.clock.boot_id);
  const auto scene_uri = builder.CreateString(description.scene_uri);
  const auto body_from_node = add_poses(builder, description.body_from_node);
  const auto node_names = add_strings(builder, description.node_names);
  const auto adapter_name = builder.CreateString(description.adapter_name);
  fbs::ClockInfoBuilder clock_table(builder);
  clock_table.add_boot_id(boot_id);
  clock_table.add_sim_seconds_per_second(description.clock.sim_seconds_per_second);
  clock_table.add_realtime_at_open_ns(description.clock.realtime_at_open_ns);
  clock_table.add_monotonic_at_open_ns(description.clock.monotonic_at_open_ns);
  const auto clock = clock_table.Finish();
  fbs::Affine3x4d world_from_stream;
  std::memcpy(static_cast<void*>(&world_from_stream), &description.world_from_stream,
              sizeof world_from_stream);
  fbs::StreamDescriptionBuilder table(builder);
  table.add_clock(clock);
  table.add_scene_uri(scene_uri);
  table.add_body_from_node(body_from_node);
  table.add_node_names(node_names);
  table.add_adapter_name(adapter_name);
  table.add_protocol_minor(description.protocol_minor);
  table.add_protocol_major(description.protocol_major);
  table.add_nominal_rate_hz(description.nominal_rate_hz);
  table.add_epoch(description.epoch);
  table.add_world_from_stream(&world_from_stream);
  return finish(builder, fbs::Body::StreamDescription, table.Finish().Union());
}

Bytes encode(const Welcome& welcome) {
  FlatBufferBuilder builder(1024);
  builder.ForceDefaults(true);
  const auto conflicting_names = add_strings(builder, welcome.conflicting_names);
  const auto unmatched_names = add_strings(builder, welcome.unmatched_names);
  const auto message = builder.CreateString(welcome.message);
  const auto renderer_name = builder.CreateString(welcome.renderer_name);
  fbs::WelcomeBuilder table(builder);
  table.add_conflicting_names(conflicting_names);
  table.add_unmatched_names(unmatched_names);
  table.add_message(message);
  table.add_renderer_name(renderer_name);
  table.add_protocol_minor(welcome.protocol_minor);
  table.add_protocol_major(welcome.protocol_major);
  table.add_epoch(welcome.epoch);
  table.add_status(static_cast<fbs::WelcomeStatus>(welcome.status));
  return finish(builder, fbs::Body::Welcome, table.Finish().Union());
}

Bytes encode(const Ack& ack) {
  FlatBufferBuilder builder(128);
  builder.ForceDefaults(true);
  fbs::AckBuilder table(builder);
  table.add_sequence(ack.sequence);
  table.add_epoch(ack.epoch);
  return finish(builder, fbs::Body::Ack, table.Finish().Union());
}

Bytes encode(const Ping& ping) {
  FlatBufferBuilder builder(128);
  builder.ForceDefaults(true);
  fbs::PingBuilder table(builder);
  table.add_sender_time_ns(ping.sender_time_ns);
  table.add_id(ping.id);
  return finish(builder, fbs::Body::Ping, table.Finish().Union());
}

Bytes encode(const Pong& pong) {
  FlatBufferBuilder builder(128);
  builder.ForceDefaults(true);
  fbs::PongBuilder table(builder);
  table.add_answer_time_ns(pong.answer_time_ns);
  table.add_ping_sender_time_ns(pong.ping_sender_time_ns);
  table.add_id(pong.id);
  return finish(builder, fbs::Body::Pong, table.Finish().Union());
}

Bytes encode(const Goodbye& goodbye) {
  FlatBufferBuilder builder(128);
  builder.ForceDefaults(true);
  fbs::GoodbyeBuilder table(builder);
  table.add_epoch(goodbye.epoch);
  return finish(builder, fbs::Body::Goodbye, table.Finish().Union());
}

Bytes encode(const Status& status) {
  FlatBufferBuilder builder(1024);
  builder.ForceDefaults(true);
  const auto message = builder.CreateString(status.message);
  const auto contested_names = add_strings(builder, status.contested_names);
  fbs::StatusBuilder table(builder);
  table.add_message(message);
  table.add_contested_names(contested_names);
  table.add_epoch(status.epoch);
  return finish(builder, fbs::Body::Status, table.Finish().Union());
}

Bytes encode(const PoseFrameView& frame) {
  return build_pose_frame(frame);
}

MessagePieces PoseFrameEncoder::encode(const PoseFrameView& frame) {
  // A pose has 48 bytes, a multiple of every alignment in the message. The head of an empty frame therefore
  // differs from others only in its last four bytes, the vector length.
  if (head_.empty()) {
    head_ = build_pose_frame({});
    const fbs::PoseFrame* table = fbs::GetMessage(head_.data())->body_as_PoseFrame();
    const auto offset_of = [&](flatbuffers::voffset_t field) {
      const uint8_t* address = reinterpret_cast<const flatbuffers::Table*>(table)->GetAddressOf(field);
      FIRE3DV_ASSERT(address != nullptr);
      return static_cast<size_t>(address - reinterpret_cast<const uint8_t*>(head_.data()));
    };
    offsets_ = {offset_of(fbs::PoseFrame::VT_EPOCH),         offset_of(fbs::PoseFrame::VT_SEQUENCE),
                offset_of(fbs::PoseFrame::VT_SIM_TIME_NS),   offset_of(fbs::PoseFrame::VT_PUBLISH_TIME_NS),
                offset_of(fbs::PoseFrame::VT_SCENE_VERSION), offset_of(fbs::PoseFrame::VT_FLAGS),
                offset_of(fbs::PoseFrame::VT_NODE_COUNT),    offset_of(fbs::PoseFrame::VT_FIRST_NODE)};
  }
  patch(head_, offsets_.epoch, frame.header.epoch);
  patch(head_, offsets_.sequence, frame.header.sequence);
  patch(head_, offsets_.sim_time, frame.header.sim_time_ns);
  patch(head_, offsets_.publish_time, frame.header.publish_time_ns);
  patch(head_, offsets_.scene_version, frame.header.scene_version);
  patch(head_, offsets_.flags, frame.header.flags);
  patch(head_, offsets_.node_count, frame.node_count);
  patch(head_, offsets_.first_node, frame.first_node);
  patch(head_, head_.size() - sizeof(uint32_t), static_cast<uint32_t>(frame.poses.size()));
  return {head_, std::as_bytes(frame.poses)};
}

uint32_t poses_per_part(size_t max_message_bytes) {
  static const size_t head_bytes = build_pose_frame({}).size();
  if (max_message_bytes <= head_bytes) return 0;
  const size_t poses = (max_message_bytes - head_bytes) / sizeof(Affine3x4);
  return static_cast<uint32_t>(poses < UINT32_MAX ? poses : UINT32_MAX);
}

}  // namespace fire3dv::wire
