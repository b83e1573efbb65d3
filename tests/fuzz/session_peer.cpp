// Message generation of fuzzed peers: valid messages with boundary values, and some invalid ones.
#include "tests/fuzz/session_peer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/fuzz/session_doubles.h"

namespace fire3dv::fuzz {
namespace {

// Names and paths of base_scene(), of added nodes and their assets, and unknown ones.
const std::vector<std::string>& names_in_use() {
  static const std::vector<std::string> names = {
      "root",      "body",       "left",       "twin",   "camera",         "root/left", "root/left/twin",
      "root/twin", "added",      "added/body", "other",  "other/camera",   "deep",      "added/deep",
      "root/body", "root/added", "a/b~c",      "nobody", "added/root/left"};
  return names;
}

uint64_t edge_number(Choices& choices, uint64_t near) {
  return choices.one_of<uint64_t>(
      {0, 1, near, near + 1, near + 1, near - 1, near + 1000, UINT64_MAX, UINT32_MAX});
}

float edge_float(Choices& choices) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  return choices.one_of({0.0f, 1.0f, -1.0f, 0.5f, 1e-30f, 9.9e11f, 1e30f, kInfinity, std::nanf(""), 3.1f});
}

// Returns a valid number in most cases.
float number(Choices& choices) {
  return choices.one_in(30) ? edge_float(choices) : static_cast<float>(choices.below(100)) / 16;
}

wire::Affine3x4 pose(Choices& choices) {
  wire::Affine3x4 pose;
  pose.m[3] = number(choices);
  if (choices.one_in(8)) pose.m[choices.below(12)] = number(choices);
  return pose;
}

}  // namespace

wire::Bytes SessionPeer::describe(Choices& choices, const std::set<uint64_t>& epochs_of_others) {
  wire::StreamDescription description;
  const uint64_t previous = epoch;
  switch (choices.below(12)) {
    case 0:
      description.epoch = previous;
      break;
    case 1:
    case 2:
      description.epoch = epochs_of_others.empty() ? 1 : choices.any_of(epochs_of_others);
      break;
    default:
      description.epoch = choices.number() | 1;
  }
  description.adapter_name = choices.one_of<const char*>({"", "adapter", "a\nb", "\xff", "adapter"});
  if (choices.one_in(40)) description.protocol_major = 2;
  const uint64_t count = choices.one_in(20) ? choices.below(2000) : choices.below(6);
  std::set<std::string> used;
  for (uint64_t i = 0; i < count; ++i) {
    const bool repeats = choices.one_in(200);
    std::string name =
        choices.one_in(8) || count > 10 ? "free " + std::to_string(i) : choices.any_of(names_in_use());
    if (used.insert(name).second || repeats) description.node_names.push_back(std::move(name));
  }
  if (choices.one_in(5)) description.body_from_node.resize(choices.below(count + 2));
  if (choices.one_in(20)) description.world_from_stream.m[choices.below(12)] = edge_float(choices);
  if (choices.one_in(4)) description.clock.boot_id = "another machine";
  wire::Bytes bytes = wire::encode(description);
  requests.clear();  // the renderer does not know the requests of a refused description
  static wire::Decoder decoder;
  const bool is_valid = decoder.decode(bytes).ok() && description.protocol_major == wire::kProtocolMajor;
  if (is_valid || description.protocol_major != wire::kProtocolMajor) {
    if (description.epoch != previous) {
      sequence_ = version_ = 0;
      names_ = description.node_names;
    }
    epoch = is_valid ? description.epoch : 0;
  }
  return bytes;
}

wire::Bytes SessionPeer::pose_frame(Choices& choices) {
  auto count = static_cast<uint32_t>(names_.size());
  if (choices.one_in(30)) count = static_cast<uint32_t>(edge_number(choices, count) % 70'000);
  wire::PoseFrameView frame;
  frame.header.epoch = choices.one_in(30) ? choices.number() : epoch;
  frame.header.sequence = choices.one_in(8) ? edge_number(choices, sequence_) : sequence_ + 1;
  if (frame.header.sequence < UINT32_MAX) sequence_ = frame.header.sequence;
  frame.header.sim_time_ns =
      static_cast<int64_t>(choices.one_in(10) ? choices.number() : sequence_ * 1'000'000);
  frame.header.publish_time_ns = choices.one_in(10) ? choices.number() : sequence_ * 1'000'000;
  frame.header.scene_version = choices.one_in(3) ? version_ : 0;
  if (choices.one_in(30)) frame.header.scene_version = edge_number(choices, version_);
  frame.header.flags = choices.one_in(10) ? static_cast<uint32_t>(choices.number()) : 0;
  frame.node_count = count;
  std::vector<uint32_t> indices;
  std::vector<wire::Affine3x4> poses(count);
  if (count > 0 && choices.one_in(4)) {  // partial
    for (uint32_t i = 0; i < count; ++i)
      if (choices.one_in(2)) indices.push_back(choices.one_in(60) ? count + i : i);
    poses.resize(indices.size());
    frame.node_indices = indices;
  } else if (count > 1 && choices.one_in(4)) {  // one part; the next part may have the same sequence
    frame.first_node = static_cast<uint32_t>(choices.below(count));
    poses.resize(1 + choices.below(count - frame.first_node));
    if (choices.one_in(2) && sequence_ > 0) --sequence_;
  }
  if (poses.size() < 10)
    for (wire::Affine3x4& each : poses) each = pose(choices);
  frame.poses = poses;
  return wire::encode(frame);
}

wire::Bytes SessionPeer::edit(Choices& choices) {
  constexpr wire::Property kAll[] = {
      wire::Property::visible, wire::Property::base_color, wire::Property::light,   wire::Property::camera,
      wire::Property::node,    wire::Property::node,       wire::Property::vertices};
  return wire::encode(edit_of(choices, kAll[choices.below(std::size(kAll))]));
}

wire::SceneEdit SessionPeer::edit_of(Choices& choices, wire::Property property) {
  wire::SceneEdit edit;
  edit.epoch = choices.one_in(30) ? choices.number() : epoch;
  edit.version = choices.one_in(20) ? edge_number(choices, version_) : version_ + 1;
  if (edit.version < UINT32_MAX) version_ = edit.version;
  edit.node = choices.any_of(names_in_use());
  edit.property = property;
  switch (choices.one_in(8) ? 99 : static_cast<int>(property)) {
    case 0:
      edit.value = wire::Visible{choices.one_in(2)};
      break;
    case 1:
      edit.value = wire::BaseColor{{number(choices), 1, 0, 1}};
      break;
    case 2: {
      wire::Light light;
      light.kind =
          choices.one_of({wire::LightKind::point, wire::LightKind::spot, wire::LightKind::directional});
      light.intensity = number(choices);
      light.range_m = number(choices);
      edit.value = light;
      break;
    }
    case 3:
      edit.value = wire::Camera{number(choices), number(choices), number(choices), number(choices)};
      break;
    case 4: {
      if (choices.one_in(3)) {
        edit.value = wire::NodeRemoved{};
        break;
      }
      wire::NodeAdded node{choices.one_in(2) ? "" : choices.any_of(names_in_use()), pose(choices), {}, {}};
      if (choices.one_in(3)) node.asset_glb = small_glb();
      if (!node.asset_glb.empty() && choices.one_in(4))
        node.asset_glb[choices.below(node.asset_glb.size())] ^= std::byte{1};
      if (node.asset_glb.empty() && choices.one_in(8)) node.asset_uri = "../scene.glb";
      edit.value = std::move(node);
      break;
    }
    case 5: {
      wire::Vertices vertices;
      vertices.positions.resize(choices.one_in(10) ? choices.below(5000) : 3);
      if (choices.one_in(2)) vertices.normals.resize(vertices.positions.size());
      if (!vertices.positions.empty()) vertices.positions[0][0] = number(choices);
      edit.value = std::move(vertices);
      break;
    }
    default:
      edit.value = wire::Cleared{};
  }
  return edit;
}

wire::Bytes SessionPeer::image_request(Choices& choices) {
  wire::ImageRequest request;
  request.epoch = choices.one_in(30) ? choices.number() : epoch;
  request.id = choices.number() | 1;
  request.place = static_cast<uint32_t>(choices.one_in(10) ? choices.below(5000) : choices.below(8));
  request.node = choices.one_in(3) ? choices.any_of(names_in_use()) : "camera";
  const auto side = static_cast<uint32_t>(choices.one_in(10) ? choices.below(9000) : 1 + choices.below(64));
  request.intrinsics = {side, side, 0, 0, 0, 0, 0, 0, {}};
  if (choices.one_in(2)) request.intrinsics = {side, side, 10, number(choices), 1, 1, 0.1f, 100, {}};
  request.outputs = choices.one_in(4) ? static_cast<uint32_t>(choices.number()) : uint32_t{wire::kColorSrgb8};
  request.when = static_cast<wire::ImageWhen>(choices.below(5));
  request.every = static_cast<uint32_t>(choices.below(4));
  request.rate_hz = number(choices);
  request.sequence = choices.one_in(3) ? edge_number(choices, sequence_) : sequence_;
  if (choices.one_in(4)) {
    wire::ImageBatch batch;
    batch.worlds = static_cast<uint32_t>(choices.one_in(8) ? choices.number() : 1 + choices.below(4));
    batch.node_indices = {static_cast<uint32_t>(choices.below(4))};
    batch.poses.resize(choices.one_in(3) ? choices.below(5) : std::min(batch.worlds, 4u));
    if (choices.one_in(3))
      batch.world_of_view.resize(choices.below(5), static_cast<uint32_t>(choices.below(5)));
    if (choices.one_in(3)) batch.active.resize(choices.below(5), static_cast<uint8_t>(choices.below(3)));
    request.batch = std::move(batch);
    request.when = wire::ImageWhen::batch;
  }
  wire::Bytes bytes = wire::encode(request);
  static wire::Decoder decoder;
  if (is_connected && epoch != 0 && request.epoch == epoch && decoder.decode(bytes).ok()) {
    if (request.when == wire::ImageWhen::never)
      requests.erase(request.place);
    else
      requests[request.place] = request.id;
  }
  return bytes;
}

wire::Bytes SessionPeer::goodbye(Choices& choices) {
  const uint64_t ended = choices.one_in(10) ? choices.number() : epoch;
  epoch = 0;
  requests.clear();
  return wire::encode(wire::Goodbye{ended});
}

wire::Bytes SessionPeer::other_message(Choices& choices) {
  switch (choices.below(7)) {
    case 0:
      return wire::encode(wire::Ack{1, choices.number()});
    case 1:
      return wire::encode(wire::Welcome{});
    case 2:
      return wire::encode(wire::Pong{choices.below(4), choices.number(), choices.number()});
    case 3:
      return wire::encode(wire::ImageRefused{1, choices.number(), wire::ImageRefusal::too_many, "no"});
    case 4: {
      wire::Bytes noise(choices.below(64));
      for (std::byte& byte : noise) byte = static_cast<std::byte>(choices.below(256));
      return noise;
    }
    default:
      return wire::encode(wire::Ping{choices.number(), choices.number()});
  }
}

}  // namespace fire3dv::fuzz
