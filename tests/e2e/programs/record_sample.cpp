// Generator of a recording for third-party readers: record_sample OUT.mcap zstd|lz4|none|small. Prints the
// expected poses of each message as JSON lines on standard output.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "protocol/record/stream_log.h"
#include "protocol/wire/encode.h"
#include "tests/unit/protocol/record/record_files.h"

namespace {

using namespace fire3dv;

constexpr uint64_t kBegun_ns = 1'700'000'000'000'000'000, kMs = 1'000'000;
constexpr uint64_t kFrames = 500;
constexpr uint32_t kNodes = 7;

// Bodies that rotate about all axes, in millimetres, Z up.
wire::Affine3x4 pose_of(uint64_t frame, uint32_t node) {
  const double angle = 0.01 * static_cast<double>(frame) * (node + 1);
  const double x = 0.36, y = 0.48, z = 0.8, c = std::cos(angle), s = std::sin(angle), d = 1 - c;
  const double rows[] = {c + x * x * d,          x * y * d - z * s, x * z * d + y * s,
                         1000 * std::sin(angle), y * x * d + z * s, c + y * y * d,
                         y * z * d - x * s,      250.0 * node,      z * x * d - y * s,
                         z * y * d + x * s,      c + z * z * d,     0.125 * static_cast<double>(frame)};
  wire::Affine3x4 pose;
  for (size_t i = 0; i < 12; ++i) pose.m[i] = static_cast<float>(rows[i]);
  return pose;
}

// An arrow along z and a cloud of two points, in the units of the bodies.
wire::Bytes marker_of(uint64_t version, const std::string& name, wire::MarkerKind kind) {
  wire::Marker marker;
  marker.kind = kind;
  marker.width = 20;
  marker.width_unit = wire::MarkerUnit::lengths;
  marker.positions = {{0, 0, 0}, {0, 0, 1000}};
  marker.colors = {0xff0080ff};
  return wire::encode(wire::SceneEdit{7, version, name, wire::Property::marker, std::move(marker)});
}

void say(uint64_t frame, uint64_t log_time_ns, const std::vector<uint32_t>& nodes) {
  std::printf("{\"sequence\": %llu, \"log_time\": \"%llu\", \"poses\": {",
              static_cast<unsigned long long>(frame), static_cast<unsigned long long>(log_time_ns));
  for (size_t i = 0; i < nodes.size(); ++i) {
    std::printf("%s\"link_%u\": [", i ? ", " : "", nodes[i]);
    const wire::Affine3x4 pose = pose_of(frame, nodes[i]);
    for (size_t k = 0; k < 12; ++k) std::printf("%s%.9g", k ? ", " : "", static_cast<double>(pose.m[k]));
    std::printf("]");
  }
  std::printf("}}\n");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  auto sink = record::create_sink(argv[1]);
  if (!sink) {
    std::fprintf(stderr, "record_sample: %s\n", sink.error().message.c_str());
    return 1;
  }
  // The source of tests/unit/protocol/record/recordings/by_mcap_core.mcap.
  if (std::strcmp(argv[2], "small") == 0)
    return (*sink)->append(record_test::small_recording(record::Compression::none)).ok() ? 0 : 1;
  record::LogOptions options;
  const bool packs = std::strcmp(argv[2], "none") != 0;
  options.writer.compression = packs ? record::compression_of(argv[2]).value() : record::Compression::none;
  options.writer.chunk_bytes = 60'000;
  options.foxglove = true;
  options.models.push_back({"scene.glb", "model/gltf-binary", record::Bytes(5000, std::byte{7})});
  record::StreamLog log([&](uint32_t) -> Result<std::unique_ptr<record::Sink>> { return std::move(*sink); },
                        [](record::Writer& writer, uint64_t now_ns) -> Result<void> {
                          record::MemorySource scene(record::Bytes(5000, std::byte{7}));
                          record::AttachmentIndex about;
                          about.log_time_ns = now_ns;
                          about.name = "scene.glb";
                          about.media_type = "model/gltf-binary";
                          if (auto good = writer.attach(about, scene); !good) return good;
                          return writer.add_metadata({"run", {{"operator", "nobody"}}});
                        },
                        options);
  wire::StreamDescription description;
  description.epoch = 7;
  description.adapter_name = "arm";
  for (uint32_t i = 0; i < kNodes; ++i) description.node_names.push_back("link_" + std::to_string(i));
  description.world_from_stream.m = {0.001, 0, 0, 0.5, 0, 0, 0.001, 0, 0, -0.001, 0, -2};
  bool good = log.take(1, wire::encode(description), kBegun_ns).ok();
  good = good && log.take(1, marker_of(1, "force", wire::MarkerKind::arrows), kBegun_ns).ok() &&
         log.take(1, marker_of(2, "cloud", wire::MarkerKind::points), kBegun_ns).ok();
  for (uint64_t frame = 1; frame <= kFrames && good; ++frame) {
    std::vector<uint32_t> nodes;
    // Whole frames, frames in two parts, and partial frames.
    const bool is_partial = frame % 5 == 0, is_cut = frame % 5 == 1;
    for (uint32_t i = 0; i < kNodes; ++i)
      if (!is_partial || i % 3 == 1) nodes.push_back(i);
    std::vector<wire::Affine3x4> poses;
    for (const uint32_t node : nodes) poses.push_back(pose_of(frame, node));
    wire::PoseFrameView view;
    view.header.epoch = 7;
    view.header.sequence = frame;
    view.header.sim_time_ns = static_cast<int64_t>(frame * kMs);
    view.node_count = kNodes;
    const uint64_t now_ns = kBegun_ns + frame * kMs;
    const size_t cut = is_cut ? 4 : nodes.size();
    for (size_t first = 0; first < nodes.size() && good; first += cut) {
      const size_t count = std::min(cut, nodes.size() - first);
      view.poses = std::span(poses).subspan(first, count);
      view.first_node = is_partial ? 0 : static_cast<uint32_t>(first);
      if (is_partial) view.node_indices = nodes;
      good = log.take(1, wire::encode(view), now_ns).ok();
      say(frame, now_ns,
          {nodes.begin() + static_cast<std::ptrdiff_t>(first),
           nodes.begin() + static_cast<std::ptrdiff_t>(first + count)});
    }
  }
  return good && log.finish().ok() ? 0 : 1;
}
