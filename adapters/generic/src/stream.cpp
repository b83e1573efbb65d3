#include "stream.h"

#include <algorithm>

#include "protocol/base/random.h"
#include "protocol/wire/check.h"

namespace wire = fire3dv::wire;

namespace {

constexpr int kMaxRepliesPerCall = 256;
constexpr uint64_t kMaxWholeFrameIntervalNs = 250'000'000;

void append_names(std::string& text, const char* what, const std::vector<std::string>& names) {
  if (names.empty()) return;
  if (!text.empty()) text += "; ";
  text += what;
  for (size_t i = 0; i < names.size() && text.size() < sizeof(fire3dv_status::welcome_message); ++i) {
    text += (i ? ", " : " ") + names[i];
  }
}

std::string welcome_text(const wire::Welcome& answer) {
  std::string text = answer.message;
  if (answer.protocol_major != wire::kProtocolMajor) {
    text = "the renderer speaks protocol " + std::to_string(answer.protocol_major) + "." +
           std::to_string(answer.protocol_minor) + ", this library " + std::to_string(wire::kProtocolMajor) +
           "." + std::to_string(wire::kProtocolMinor) + ": use versions with the same major number";
  }
  append_names(text, "no scene node is called", answer.unmatched_names);
  append_names(text, "another stream drives", answer.conflicting_names);
  return wire::printable(text, sizeof(fire3dv_status::welcome_message) - 1);
}

}  // namespace

fire3dv::Result<void> fire3dv_stream::describe(wire::StreamDescription description) {
  description.epoch = fire3dv::random_id();
  description.adapter_name = adapter_name;
  description.clock = fire3dv::client::read_clocks();
  const fire3dv::Result<void> taken = link->set_description(wire::encode(description));
  if (!taken.ok()) return taken;
  epoch = description.epoch;
  node_count = static_cast<uint32_t>(description.node_names.size());
  max_pose_message_bytes = link->max_pose_message_bytes();
  poses_per_part = wire::poses_per_part(max_pose_message_bytes);
  sequence = 0;
  acked_sequence = 0;
  welcome = -1;
  unmatched_names = conflicting_names = contested_names = 0;
  welcome_message.clear();
  status_message.clear();
  has_cached_poses = false;
  if (auto sent = resend_edits(); !sent) return sent;
  return images.restart_epoch(*link, epoch);
}

// A new epoch starts without edits on the link, so all stored edits are sent again under it.
fire3dv::Result<void> fire3dv_stream::resend_edits() {
  scene_version = 0;
  edits.set_epoch(epoch);
  for (wire::EditStore::Stored& stored : edits.in_order()) {
    const uint64_t version = stored.version;
    if (auto taken = link->put_state(stored.key, std::move(stored.message)); !taken) return taken;
    scene_version = version;
  }
  return {};
}

fire3dv::Result<void> fire3dv_stream::send_edit(wire::EditStore::Prepared prepared) {
  const uint64_t version = prepared.stored.version;
  if (epoch != 0) {
    if (auto taken = link->put_state(prepared.stored.key, prepared.stored.message); !taken) return taken;
    scene_version = version;
  }
  edits.commit(std::move(prepared));
  return {};
}

void fire3dv_stream::publish(int64_t sim_time_ns, uint32_t flags,
                             std::span<const wire::Affine3x4> stream_from_body) {
  wire::PoseFrameView frame;
  const uint64_t now_ns = fire3dv::client::monotonic_now_ns();
  frame.header = {epoch, ++sequence, sim_time_ns, now_ns, scene_version, flags};
  if (has_cached_poses) {
    whole_at_ns = now_ns;
    if (stream_from_body.data() != cached_poses.data()) cache_poses(stream_from_body);
  }
  frame.node_count = node_count;
  ++frames_published;
  if (stream_from_body.size() <= poses_per_part) {
    frame.poses = stream_from_body;
    link->publish(encoder.encode(frame));
    return;
  }
  for (size_t first = 0; first < stream_from_body.size(); first += poses_per_part) {
    const size_t count = std::min<size_t>(poses_per_part, stream_from_body.size() - first);
    frame.first_node = static_cast<uint32_t>(first);
    frame.poses = stream_from_body.subspan(first, count);
    link->publish(encoder.encode(frame), first + count == stream_from_body.size());
  }
}

void fire3dv_stream::read_replies() {
  for (int i = 0; i < kMaxRepliesPerCall && link->poll(reply); ++i) {
    const fire3dv::Result<wire::Message> message = decoder.decode(reply);
    if (!message.ok()) continue;  // malformed reply: dropped, as SPEC.md requires
    if (const auto* answer = std::get_if<wire::Welcome>(&*message)) on(*answer);
    if (const auto* ack = std::get_if<wire::Ack>(&*message)) on(*ack);
    if (const auto* ping = std::get_if<wire::Ping>(&*message)) on(*ping);
    if (const auto* status = std::get_if<wire::Status>(&*message)) on(*status);
    if (const auto* refused = std::get_if<wire::ImageRefused>(&*message)) images.on(*refused);
  }
}

// Epoch 0 answers a description that the renderer could not decode; it may be this stream's.
void fire3dv_stream::on(const wire::Welcome& answer) {
  if (answer.epoch != epoch && answer.epoch != 0) return;
  welcome = static_cast<int32_t>(answer.status);
  unmatched_names = static_cast<uint32_t>(answer.unmatched_names.size());
  conflicting_names = static_cast<uint32_t>(answer.conflicting_names.size());
  welcome_message = welcome_text(answer);
}

void fire3dv_stream::on(const wire::Status& status) {
  if (status.epoch != epoch) return;
  contested_names = static_cast<uint32_t>(status.contested_names.size());
  status_message.clear();
  append_names(status_message, "this stream drives, and another stream requests", status.contested_names);
  status_message = wire::printable(status_message, sizeof(fire3dv_status::welcome_message) - 1);
}

std::string fire3dv_stream::status_text() const {
  if (status_message.empty()) return welcome_message;
  return wire::printable(welcome_message + "; " + status_message,
                         sizeof(fire3dv_status::welcome_message) - 1);
}

void fire3dv_stream::on(const wire::Ack& ack) {
  if (ack.epoch == epoch && ack.sequence <= sequence) acked_sequence = std::max(acked_sequence, ack.sequence);
}

void fire3dv_stream::on(const wire::Ping& ping) {
  link->send_control(
      wire::encode(wire::Pong{ping.id, ping.sender_time_ns, fire3dv::client::monotonic_now_ns()}));
}

// --- partial frames: the stream caches all poses, so that a link can send the whole frame to readers without
// its base

void fire3dv_stream::cache_poses(std::span<const wire::Affine3x4> stream_from_body) {
  cached_poses.assign(stream_from_body.begin(), stream_from_body.end());
  has_cached_poses = true;
}

void fire3dv_stream::publish_some(int64_t sim_time_ns, uint32_t flags, std::span<const uint32_t> node_indices,
                                  std::span<const wire::Affine3x4> stream_from_body) {
  const uint64_t now_ns = fire3dv::client::monotonic_now_ns();
  const bool is_whole = node_indices.size() == node_count;
  if (is_whole)
    cache_poses(stream_from_body);
  else
    for (size_t i = 0; i < node_indices.size(); ++i) cached_poses[node_indices[i]] = stream_from_body[i];
  if (is_whole || !link->takes_partial_frames() || now_ns - whole_at_ns >= kMaxWholeFrameIntervalNs)
    return publish(sim_time_ns, flags, cached_poses);

  wire::PoseFrameView frame;
  frame.header = {epoch, ++sequence, sim_time_ns, now_ns, scene_version, flags};
  frame.node_count = node_count;
  frame.node_indices = node_indices;
  frame.poses = stream_from_body;
  ++frames_published;
  const wire::Bytes partial = wire::encode(frame);
  frame.node_indices = {};
  whole.clear();
  const size_t parts = std::max<size_t>(1, (cached_poses.size() + poses_per_part - 1) / poses_per_part);
  part_encoders.resize(std::max(parts, part_encoders.size()));
  for (size_t part = 0; part < parts; ++part) {
    const size_t first = part * poses_per_part;
    frame.first_node = static_cast<uint32_t>(first);
    frame.poses = std::span<const wire::Affine3x4>(cached_poses)
                      .subspan(first, std::min<size_t>(poses_per_part, cached_poses.size() - first));
    whole.push_back(part_encoders[part].encode(frame));
  }
  link->publish_partial({partial, {}}, whole);
}
