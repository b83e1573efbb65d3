#include "stream.h"

#include <time.h>

#include <algorithm>
#include <cstring>
#include <fstream>

#include "base/plural.h"
#include "base/random.h"
#include "protocol/transport/core/absence.h"
#include "protocol/wire/check.h"

namespace wire = fire3dv::wire;

namespace {

constexpr int kMaxRepliesPerCall = 256;
constexpr uint64_t kMaxWholeFrameIntervalNs = 250'000'000;
constexpr size_t kMaxAdvice = 32;  // that nobody has polled
constexpr size_t kMaxNameBytesInAll = size_t{128} << 20;

int64_t realtime_ns() noexcept {
  timespec time{};
  ::clock_gettime(CLOCK_REALTIME, &time);
  return int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

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
  fit_parts_to_link();
  sequence = 0;
  last_sim_time_ns = 0;
  acked_sequence = 0;
  welcome = -1;
  unmatched_names = conflicting_names = contested_names = 0;
  welcome_message.clear();
  status_message.clear();
  advice.clear();
  has_cached_poses = false;
  inputs.restart_epoch();
  if (auto sent = resend_edits(); !sent) return sent;
  return images.restart_epoch(*link, epoch);
}

// A UDP link shortens its datagrams on a path that does not carry longer ones.
void fire3dv_stream::fit_parts_to_link() {
  const size_t most = link->max_pose_message_bytes();
  if (most == max_pose_message_bytes) return;
  max_pose_message_bytes = most;
  poses_per_part = wire::poses_per_part(most);
}

// A new epoch starts without edits on the link, so all stored edits are sent again under it.
fire3dv::Result<void> fire3dv_stream::resend_edits() {
  scene_version = 0;
  edits.set_epoch(epoch);
  for (wire::EditStore::Stored& stored : edits.in_order()) {
    const uint64_t version = stored.version;
    if (auto taken = link->put_state(stored.key, std::move(stored.message)); !taken) return taken;
    if (wire::delays_frames(stored.property)) scene_version = version;
  }
  return {};
}

fire3dv::Result<void> fire3dv_stream::send_edit(wire::EditStore::Prepared prepared) {
  const uint64_t version = prepared.stored.version;
  if (epoch != 0) {
    if (auto taken = link->put_state(prepared.stored.key, prepared.stored.message); !taken) return taken;
    if (wire::delays_frames(prepared.name.second)) scene_version = version;
  }
  edits.commit(std::move(prepared));
  return {};
}

void fire3dv_stream::publish(int64_t sim_time_ns, uint32_t flags,
                             std::span<const wire::Affine3x4> stream_from_body) {
  wire::PoseFrameView frame;
  fit_parts_to_link();
  const uint64_t now_ns = fire3dv::client::monotonic_now_ns();
  frame.header = {epoch, ++sequence, sim_time_ns, now_ns, scene_version, flags};
  last_sim_time_ns = sim_time_ns;
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
    if (const auto* event = std::get_if<wire::InputEvent>(&*message); event && takes_input)
      inputs.on(*event, epoch, node_count, fire3dv::client::monotonic_now_ns());
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
  // Advice concerns poses and edits of this description; a status without any does not take it back.
  if (status.message.starts_with("this stream ")) {
    std::string text = wire::printable(status.message, sizeof(fire3dv_status::welcome_message) - 1);
    if (advice.size() == kMaxAdvice) advice.erase(advice.begin());
    if (std::ranges::find(advice, text) == advice.end()) advice.push_back(std::move(text));
  }
  status_message.clear();
  append_names(status_message, "this stream drives, and another stream requests", status.contested_names);
  status_message = wire::printable(status_message, sizeof(fire3dv_status::welcome_message) - 1);
}

std::string fire3dv_stream::status_text() const {
  constexpr size_t kRoom = sizeof(fire3dv_status::welcome_message) - 1;
  std::string text = welcome_message;
  if (!status_message.empty()) text += "; " + status_message;
  if (advice.empty()) return wire::printable(text, kRoom);
  const std::string& shown = advice.front();
  // Long lists of names leave half of the room to the advice.
  text = wire::printable(text, std::max(kRoom / 2, kRoom - std::min(kRoom, shown.size() + 2)));
  return wire::printable(text + "; " + shown, kRoom);
}

std::string fire3dv_stream::reach_text() const {
  const uint32_t renderers = link->stats().peers;
  if (renderers == 0) {
    const std::string problem = link->problem();
    if (!problem.empty()) return "no renderer is reached: " + problem;
    const std::string absence = fire3dv::transport::absence_of(*link);
    return "no renderer is reached: " + (absence.empty() ? "" : absence + "; ") +
           "start `fire3dv SCENE --listen " + uri + "`, or correct the URI";
  }
  const std::string reached =
      fire3dv::counted(renderers, "renderer") + (renderers == 1 ? " is" : " are") + " reached";
  if (welcome < 0) return reached + ", but none has answered the description of this stream";
  return welcome == 0 ? reached : reached + ", which does not accept this stream: " + welcome_message;
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
  last_sim_time_ns = sim_time_ns;
  frame.node_count = node_count;
  frame.node_indices = node_indices;
  frame.poses = stream_from_body;
  ++frames_published;
  const wire::Bytes partial = wire::encode(frame);
  frame.node_indices = {};
  whole.clear();
  fit_parts_to_link();
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

namespace fire3dv::client {

wire::DecodeLimits outgoing_limits() {
  return {};
}

wire::DecodeLimits incoming_limits() {
  wire::DecodeLimits limits;
  limits.max_message_bytes = size_t{64} << 20;  // a Welcome may list every name of a large scene
  return limits;
}

wire::ClockInfo read_clocks() {
  wire::ClockInfo clocks;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> clocks.boot_id;  // stays empty without /proc
  if (!wire::check_text("boot_id", clocks.boot_id, 64).ok()) clocks.boot_id.clear();
  clocks.monotonic_at_open_ns = monotonic_now_ns();
  clocks.realtime_at_open_ns = realtime_ns();
  return clocks;
}

Result<wire::StreamDescription> read_description(const fire3dv_description& description) {
  const wire::DecodeLimits limits = outgoing_limits();
  if (description.node_count > limits.max_nodes) {
    return Error{"node_count is " + std::to_string(description.node_count) + "; at most " +
                 std::to_string(limits.max_nodes) + " nodes are allowed"};
  }
  if (description.node_count > 0 && !description.node_names) return Error{"node_names is NULL"};
  const size_t matrices = description.body_from_node_count;
  if (matrices > 1 && matrices != description.node_count) {
    return Error{"body_from_node_count is " + std::to_string(matrices) + "; 0, 1 or node_count (" +
                 std::to_string(description.node_count) + ") are allowed"};
  }
  if (matrices > 0 && !description.body_from_node)
    return Error{"body_from_node is NULL but its count is not 0"};

  wire::StreamDescription result;
  size_t name_bytes = 0;
  for (size_t i = 0; i < description.node_count; ++i) {
    const char* name = description.node_names[i];
    if (!name) return Error{"node_names[" + std::to_string(i) + "] is NULL"};
    // One byte above the limit suffices for the check below to refuse the name.
    result.node_names.emplace_back(name, ::strnlen(name, limits.max_name_bytes + 1));
    name_bytes += result.node_names.back().size();
  }
  if (name_bytes > kMaxNameBytesInAll)
    return Error{"node_names are longer than 128 MiB together: use shorter names"};
  if (description.world_from_stream) {
    std::copy_n(description.world_from_stream, 12, result.world_from_stream.m.begin());
  }
  result.body_from_node.resize(matrices);
  for (size_t i = 0; i < matrices; ++i) {
    std::copy_n(description.body_from_node + 12 * i, 12, result.body_from_node[i].m.begin());
  }
  result.nominal_rate_hz = description.nominal_rate_hz;
  if (description.scene_uri) {
    result.scene_uri.assign(description.scene_uri,
                            ::strnlen(description.scene_uri, limits.max_text_bytes + 1));
  }
  result.epoch = 1;  // placeholder, not 0; the stream sets its own epoch
  const Result<void> good = wire::check(result, limits);
  if (!good.ok()) return good.error();
  return result;
}

bool struct_is_known(const void* data, size_t struct_size, size_t known_size) {
  constexpr size_t kSaneSize = 4096;
  if (struct_size < known_size || struct_size > kSaneSize) return false;
  const auto* bytes = static_cast<const unsigned char*>(data);
  return std::all_of(bytes + known_size, bytes + struct_size, [](unsigned char byte) { return byte == 0; });
}

}  // namespace fire3dv::client
