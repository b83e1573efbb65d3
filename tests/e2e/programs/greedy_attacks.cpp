#include "tests/e2e/programs/greedy_attacks.h"

#include <fstream>
#include <iterator>
#include <memory>
#include <thread>

#include "base/random.h"
#include "tests/e2e/programs/colliding_names.h"
#include "tests/e2e/programs/raw_peer.h"
#include "tests/e2e/programs/raw_udp.h"

namespace fire3dv::test {
namespace {

using namespace std::chrono_literals;

constexpr auto kSyncLimit = 2000ms;
constexpr float kFarAway_m = 10'000;  // outside of every camera of the test

// Between repetitions of an attack.
void pause(std::chrono::milliseconds time) {
  announce_sent();
  for (const auto until = std::chrono::steady_clock::now() + time;
       !stop_requested() && std::chrono::steady_clock::now() < until;)
    std::this_thread::sleep_for(5ms);
}

wire::Affine3x4 place(float x, float y) {
  wire::Affine3x4 pose;
  pose.m[3] = x;
  pose.m[7] = y;
  return pose;
}

// A stream that describes itself, edits and requests.
class Stream : public RawPeer {
 public:
  explicit Stream(const Target& target, std::vector<std::string> names = {"nobody"}, uint64_t epoch = 0,
                  int receive_buffer_bytes = 0)
      : RawPeer(target.tcp_uri, receive_buffer_bytes) {
    description_.adapter_name = "greedy";
    describe(std::move(names), epoch);
  }
  void describe(std::vector<std::string> names, uint64_t epoch = 0) {
    description_.node_names = std::move(names);
    describe_again(epoch);
  }
  void describe_again(uint64_t epoch = 0) {
    description_.epoch = epoch != 0 ? epoch : fire3dv::random_id();
    version_ = sequence_ = 0;
    control(wire::encode(description_));
  }
  void edit(const std::string& node, wire::Property property, wire::EditValue value) {
    state(wire::encode(wire::SceneEdit{description_.epoch, ++version_, node, property, std::move(value)}));
  }
  void add(const std::string& node, const std::string& parent = {}, float x = 0,
           std::vector<std::byte> asset = {}) {
    edit(node, wire::Property::node, wire::NodeAdded{parent, place(x, kFarAway_m), {}, std::move(asset)});
  }
  void publish(uint32_t poses, float offset = 0) {
    const std::vector<wire::Affine3x4> all(poses, place(offset, 0));
    wire::PoseFrameView frame;
    frame.header.epoch = description_.epoch;
    frame.header.sequence = ++sequence_;
    frame.node_count = static_cast<uint32_t>(description_.node_names.size());
    frame.poses = all;
    pose(wire::encode(frame));
  }
  void request(uint32_t place, uint32_t side, uint32_t outputs, wire::ImageWhen when) {
    control(make_request(place, side, outputs, when));
  }
  // More requests than fit among the control messages.
  void request_as_state(uint32_t place, uint32_t side, uint32_t outputs, wire::ImageWhen when) {
    state(make_request(place, side, outputs, when));
  }

 private:
  wire::Bytes make_request(uint32_t place, uint32_t side, uint32_t outputs, wire::ImageWhen when) {
    wire::ImageRequest request;
    request.epoch = description_.epoch;
    request.id = ++request_;
    request.place = place;
    const auto size = static_cast<float>(side);
    request.intrinsics = {side, side, size, size, size / 2, size / 2, 0.1f, 100, {}};
    request.outputs = outputs;
    request.when = when;
    request.rate_hz = 1000;
    return wire::encode(request);
  }

  wire::StreamDescription description_;
  uint64_t version_ = 0, sequence_ = 0, request_ = 0;
};

std::vector<std::byte> read_file(const std::string& name) {
  std::ifstream file(name, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

// One node whose asset is replaced again and again: images that are short as files and long as pixels.
void assets(const Target& target) {
  Stream stream(target);
  const auto asset = read_file(target.asset);
  while (!stop_requested()) {
    stream.add("asset", {}, 0, asset);
    stream.sync(kSyncLimit);
    pause(50ms);
  }
}

void lights(const Target& target, int count) {
  Stream stream(target);
  wire::Light light;
  light.range_m = 1;
  for (int i = 0; i < count; ++i) {
    const std::string name = "light " + std::to_string(i);
    stream.add(name, {}, 10.0f * static_cast<float>(i));
    stream.edit(name, wire::Property::light, light);
  }
  while (!stop_requested()) {
    stream.sync(kSyncLimit);
    pause(50ms);
  }
}

void orphan_vertices(const Target& target) {
  constexpr size_t kVertices = 2'800'000;  // 32 MiB
  Stream stream(target);
  const wire::Vertices vertices{std::vector<std::array<float, 3>>(kVertices), {}};
  for (int i = 0; i < 40 && !stop_requested(); ++i) {
    stream.edit("nobody " + std::to_string(i), wire::Property::vertices, vertices);
    stream.sync(kSyncLimit);
  }
  pause(60s);
}

void nested_names(const Target& target) {
  constexpr int kDepth = 150, kLeaves = 4000;
  Stream stream(target);
  const auto name = [](int level) { return std::to_string(level) + std::string(1000, 'x'); };
  for (int i = 0; i < kDepth; ++i) stream.add(name(i), i == 0 ? "" : name(i - 1));
  for (int i = 0; i < kLeaves; ++i) stream.add("leaf " + std::to_string(i), name(kDepth - 1));
  while (!stop_requested()) {
    stream.sync(kSyncLimit);
    pause(50ms);
  }
}

void many_names(const Target& target) {
  constexpr int kNames = 1'000'000;
  std::vector<std::string> names(kNames);
  for (int i = 0; i < kNames; ++i) names[static_cast<size_t>(i)] = "name " + std::to_string(i);
  Stream owner(target, std::move(names));
  Stream other(target);
  while (!stop_requested()) {
    for (int i = 0; i < 200; ++i) other.describe_again();
    other.sync(kSyncLimit);
    announce_sent();
    owner.read_replies();
  }
}

void many_nodes(const Target& target, const std::vector<std::string>& names) {
  Stream stream(target);
  for (const std::string& name : names) stream.add(name);
  for (bool there = false; !stop_requested(); there = !there) {
    if (there) stream.edit("toggled", wire::Property::node, wire::NodeRemoved{});
    if (!there) stream.add("toggled");
    pause(20ms);
    stream.read_replies();
  }
}

void empty_nodes(const Target& target) {
  std::vector<std::string> names;
  for (int i = 0; i < 40'000; ++i) names.push_back("empty " + std::to_string(i));
  many_nodes(target, names);
}

void edit_of_root(const Target& target, wire::Property property, const wire::EditValue& value) {
  Stream stream(target);
  stream.edit("root", property, value);
  while (!stop_requested()) {
    stream.sync(kSyncLimit);
    pause(20ms);
  }
}

// "twin" is the name of two nodes; the honest peer drives one of them by its path.
void duplicate_path(const Target& target) {
  Stream stream(target);
  stream.add("twin", "left");
  while (!stop_requested()) {
    stream.sync(kSyncLimit);
    pause(20ms);
  }
}

void slow_readers(const Target& target) {
  std::vector<std::unique_ptr<Stream>> streams;
  constexpr int kReceiveBuffer = 4096;
  for (int i = 0; i < 2; ++i)
    streams.push_back(
        std::make_unique<Stream>(target, std::vector<std::string>{"nobody"}, 0, kReceiveBuffer));
  // More than 1 GiB of images in total, each drawn once: drawing is not what harms others here.
  for (const auto& stream : streams)
    for (uint32_t i = 0; i < 40; ++i)
      stream->request(i, 700, wire::kRequestableOutputs, wire::ImageWhen::once);
  while (!stop_requested()) {
    for (const auto& stream : streams) stream->publish(1);
    pause(20ms);
  }
}

void large_requests(const Target& target) {
  Stream stream(target);
  for (uint32_t i = 0; i < 16; ++i) stream.request(i, 4096, wire::kColorSrgb8, wire::ImageWhen::rate);
  while (!stop_requested()) {
    stream.publish(1);
    stream.read_replies();
    pause(20ms);
  }
}

// More small images of each frame than fit into a time slice, and some large ones.
void many_requests(const Target& target) {
  constexpr uint32_t kSmall = 900, kLarge = 24;
  Stream stream(target);
  stream.publish(1);
  for (uint32_t i = 0; i < kSmall; ++i) stream.request_as_state(i, 8, wire::kMotion, wire::ImageWhen::rate);
  for (uint32_t i = 0; i < kLarge; ++i)
    stream.request_as_state(kSmall + i, 1000 + i, wire::kColorSrgb8, wire::ImageWhen::once);
  while (!stop_requested()) {
    stream.publish(1);
    stream.read_replies();
    pause(5ms);
  }
}

// Visits that add a node and leave.
void reconnects(const Target& target) {
  for (uint64_t visit = 0; !stop_requested(); ++visit) {
    try {
      Stream stream(target, {"visitor " + std::to_string(visit)});
      stream.add("node " + std::to_string(visit));
      stream.publish(1);
    } catch (const PeerClosed&) {  // the listener is full
    }
    announce_sent();
  }
}

// A bundle of zeros is one of two million scene edits without content.
void empty_states(const Target& target) {
  const RawPeer announcement(target.tcp_uri);
  const std::vector<std::byte> zeros(size_t{16} << 20);
  while (!stop_requested()) {
    send_bundle(target.udp_uri, zeros);
    announce_sent();
  }
}

// A description of many names, and frames of which one pose comes each.
void half_frames(const Target& target) {
  std::vector<std::string> names(1'000'000);
  for (size_t i = 0; i < names.size(); ++i) names[i] = std::to_string(i);
  Stream stream(target, std::move(names));
  while (!stop_requested()) {
    for (int part = 0; part < 8; ++part) stream.publish(1);
    stream.sync(kSyncLimit);
    pause(50ms);
  }
}

void silent_connections(const Target& target) {
  std::vector<std::unique_ptr<RawPeer>> peers;
  for (int i = 0; i < 64; ++i) {
    peers.push_back(std::make_unique<RawPeer>(target.tcp_uri));
    peers.back()->control(wire::encode(wire::Ping{1, 1}));
  }
  while (!stop_requested()) pause(50ms);
}

void squatter(const Target& target, uint64_t epoch) {
  Stream stream(target, target.nodes, epoch);
  while (!stop_requested()) {
    stream.publish(static_cast<uint32_t>(target.nodes.size()), 0.3f);
    stream.sync(kSyncLimit);
    pause(10ms);
  }
}

}  // namespace

const std::map<std::string, Attack>& greedy_attacks() {
  using wire::Property;
  static const std::map<std::string, Attack> attacks = {
      {"huge_images", assets},
      {"busy_builds", assets},
      {"lights_1000", [](const Target& t) { lights(t, 1000); }},
      {"lights_5000", [](const Target& t) { lights(t, 5000); }},
      {"orphan_vertices", orphan_vertices},
      {"nested_names", nested_names},
      {"many_names", many_names},
      {"empty_nodes", empty_nodes},
      {"colliding_names", [](const Target& t) { many_nodes(t, colliding_names(1 << 14)); }},
      {"hidden_root", [](const Target& t) { edit_of_root(t, Property::visible, wire::Visible{false}); }},
      {"removed_root", [](const Target& t) { edit_of_root(t, Property::node, wire::NodeRemoved{}); }},
      {"duplicate_path", duplicate_path},
      {"slow_readers", slow_readers},
      {"large_requests", large_requests},
      {"many_requests", many_requests},
      {"reconnects", reconnects},
      {"empty_states", empty_states},
      {"half_frames", half_frames},
      {"silent_connections", silent_connections},
      {"squatter", [](const Target& t) { squatter(t, 0); }},
      {"epoch_takeover", [](const Target& t) { squatter(t, t.epoch); }},
  };
  return attacks;
}

}  // namespace fire3dv::test
