// Generator of a recording that covers every ordering rule, for tests of offline rendering:
//
//   offline_recording OUT.mcap ASSET.glb [attach]
//
// Two streams share a clock. "arm" moves red and green at 100 Hz, in two runs, with partial frames, a jump,
// and edits: visibility, colour, and a node with ASSET that is added and removed. "crane" moves blue at 25 Hz
// and starts later. attach: ASSET is an attachment of the recording.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "protocol/record/stream_log.h"
#include "protocol/wire/encode.h"

namespace {

using namespace fire3dv;

constexpr uint64_t kMs = 1'000'000;
constexpr uint64_t kBegunNs = 1'700'000'000'000'000'000;
constexpr uint64_t kArm = 1, kCrane = 2;  // peers

class Recording {
 public:
  Recording(const std::string& out, const std::string& asset, bool attach)
      : asset_(asset),
        log_([out](uint32_t) { return record::create_sink(out); },
             [asset, attach](record::Writer& writer, uint64_t log_time_ns) -> Result<void> {
               if (!attach) return {};
               auto source = record::open_source(asset);
               if (!source) return source.error();
               record::AttachmentIndex about;
               about.log_time_ns = log_time_ns;
               about.name = "asset.glb";
               about.media_type = "model/gltf-binary";
               return writer.attach(about, **source);
             },
             small_chunks()) {}

  bool make() {
    describe(kArm, 0x11, "arm", {"red", "green"});
    for (uint64_t s = 1; s <= 60; ++s) {
      if (s == 10) describe(kCrane, 0x33, "crane", {"blue"});
      if (s == 20) edit("green", wire::Property::visible, wire::Visible{false});
      if (s == 25) edit("extra", wire::Property::node, asset_node());
      if (s == 40) edit("extra", wire::Property::node, wire::NodeRemoved{});
      if (s == 45) edit("red", wire::Property::base_color, wire::BaseColor{{0.5f, 0.5f, 0, 1}});
      if (s == 50) edit("green", wire::Property::visible, wire::Visible{true});
      arm(0x11, s, s == 30 ? wire::kFrameDiscontinuity : 0u, s > 50 && s % 4 != 0);
      if (s >= 12 && s % 4 == 0) crane(s);
    }
    take(kArm, wire::encode(wire::Goodbye{0x11}));
    now_ms_ += 2000;  // pause between the runs
    version_ = 0;
    describe(kArm, 0x22, "arm", {"green", "red"});
    for (uint64_t s = 1; s <= 20; ++s) arm(0x22, s, 0, false);
    take(kArm, wire::encode(wire::Goodbye{0x22}));
    good_ = good_ && log_.finish().ok();
    return good_;
  }

 private:
  static record::LogOptions small_chunks() {
    record::LogOptions options;
    options.writer.chunk_bytes = 4096;
    return options;
  }
  void take(uint64_t peer, const wire::Bytes& message) {
    const auto taken = log_.take(peer, message, kBegunNs + now_ms_ * kMs);
    if (!taken) std::fprintf(stderr, "offline_recording: %s\n", taken.error().message.c_str());
    good_ = good_ && taken.ok();
  }
  void describe(uint64_t peer, uint64_t epoch, const std::string& name, std::vector<std::string> nodes) {
    wire::StreamDescription description;
    description.epoch = epoch;
    description.adapter_name = name;
    description.node_names = std::move(nodes);
    take(peer, wire::encode(description));
  }
  void edit(const std::string& node, wire::Property property, wire::EditValue value) {
    take(kArm, wire::encode(wire::SceneEdit{0x11, ++version_, node, property, std::move(value)}));
  }
  wire::NodeAdded asset_node() const {
    wire::NodeAdded node;
    node.parent_from_node.m = {1, 0, 0, -60, 0, 1, 0, -20, 0, 0, 1, 5};
    std::ifstream file(asset_, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    node.asset_glb.resize(bytes.size());
    std::memcpy(node.asset_glb.data(), bytes.data(), bytes.size());
    return node;
  }
  // Rotates and translates, so that each time between two frames has a unique pose.
  static wire::Affine3x4 pose(float x, float angle) {
    const float c = std::cos(angle), s = std::sin(angle);
    wire::Affine3x4 pose;
    pose.m = {c, -s, 0, x, s, c, 0, 0, 0, 0, 1, 0};
    return pose;
  }
  void arm(uint64_t epoch, uint64_t sequence, uint32_t flags, bool partial) {
    now_ms_ += 10;
    const auto s = static_cast<float>(sequence);
    const float jump = sequence >= 30 ? 15.0f : 0.0f;
    const std::vector<wire::Affine3x4> poses{pose(-70 + 1.7f * s + jump, 0.05f * s),
                                             pose(60 - 1.3f * s, -0.04f * s)};
    const uint32_t moved[] = {0};
    wire::PoseFrameView frame;
    frame.header = {epoch,         sequence, static_cast<int64_t>(sequence * 10 * kMs),
                    now_ms_ * kMs, version_, flags};
    frame.node_count = 2;
    frame.poses = partial ? std::span(poses).first(1) : std::span(poses);
    if (partial) frame.node_indices = moved;
    take(kArm, wire::encode(frame));
  }
  void crane(uint64_t at) {
    const wire::Affine3x4 blue = pose(-50 + static_cast<float>(at), 0.01f * static_cast<float>(at));
    wire::PoseFrameView frame;
    frame.header = {0x33, at / 4, static_cast<int64_t>(at * 10 * kMs), now_ms_ * kMs, 0, 0};
    frame.node_count = 1;
    frame.poses = {&blue, 1};
    take(kCrane, wire::encode(frame));
  }

  std::string asset_;
  record::StreamLog log_;
  uint64_t now_ms_ = 0, version_ = 0;
  bool good_ = true;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  return Recording(argv[1], argv[2], argc > 3).make() ? 0 : 1;
}
