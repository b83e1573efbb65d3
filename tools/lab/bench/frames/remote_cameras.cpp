#include "tools/lab/bench/frames/frame_commands.h"

#include <cstdio>
#include <memory>
#include <thread>

#include "fire3dv/client.h"
#include "fire3dv/image.h"
#include "protocol/base/clock.h"
#include "protocol/wire/image_outputs.h"
#include "renderer/passes/view.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tools/lab/bench/bench_camera.h"
#include "tools/lab/bench/report/statistics.h"

namespace fire3dv::bench {
namespace {

constexpr uint32_t kWaitMs = 60'000;

struct CloseStream {
  void operator()(fire3dv_stream* stream) const { fire3dv_close(&stream); }
};
using Stream = std::unique_ptr<fire3dv_stream, CloseStream>;

Error client_error(const char* what) {
  return Error{std::string(what) + ": " + fire3dv_last_error()};
}

// Opens a stream that drives no scene node.
Result<Stream> open_stream(const std::string& uri) {
  fire3dv_options options{};
  options.struct_size = sizeof(options);
  options.adapter_name = "bench";
  Stream stream(fire3dv_open(uri.c_str(), &options));
  if (!stream) return client_error("--to");
  const char* const name = "nothing of the scene";
  fire3dv_description description{};
  description.struct_size = sizeof(description);
  description.node_names = &name;
  description.node_count = 1;
  if (fire3dv_describe(stream.get(), &description) != FIRE3DV_OK) return client_error("description");
  fire3dv_status status{};
  status.struct_size = sizeof(status);
  const int64_t begin_ns = fire3dv::monotonic_ns();
  while (status.renderers == 0) {
    fire3dv_poll(stream.get(), &status);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    if (fire3dv::monotonic_ns() - begin_ns > int64_t{kWaitMs} * 1'000'000)
      return Error{"--to " + uri + ": no renderer has come within a minute"};
  }
  return stream;
}

// FNV-1a over all bytes, to compare images of different devices.
uint64_t digest_of(uint64_t digest, const fire3dv_image& image) {
  for (size_t i = 0; i < image.plane_count; ++i) {
    const fire3dv_image_plane& plane = image.planes[i];
    const auto* bytes = static_cast<const uint8_t*>(plane.data);
    for (size_t at = 0; at < size_t{plane.row_stride} * plane.height; ++at)
      digest = (digest ^ bytes[at]) * 0x100000001b3;
  }
  return digest;
}

// Sums one byte per cache line.
uint64_t look_at(const fire3dv_image& image) {
  uint64_t sum = 0;
  for (size_t i = 0; i < image.plane_count; ++i) {
    const fire3dv_image_plane& plane = image.planes[i];
    const auto* bytes = static_cast<const uint8_t*>(plane.data);
    for (size_t at = 0; at < size_t{plane.row_stride} * plane.height; at += 64) sum += bytes[at];
  }
  return sum;
}

Result<std::vector<uint64_t>> ask(fire3dv_stream* stream, const CamerasOptions& options,
                                  const std::vector<glm::mat4>& cameras, uint32_t outputs) {
  std::vector<uint64_t> ids;
  const passes::Intrinsics lens =
      passes::intrinsics_of(scene::Camera(), {options.draw.width, options.draw.height});
  for (const glm::mat4& world_from_camera : cameras) {
    float pose[12];
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column) pose[row * 4 + column] = world_from_camera[column][row];
    fire3dv_image_request request{};
    request.struct_size = sizeof(request);
    request.parent_from_camera = pose;
    request.width = options.draw.width;
    request.height = options.draw.height;
    request.fx = lens.fx_px;
    request.fy = lens.fy_px;
    request.cx = lens.cx_px;
    request.cy = lens.cy_px;
    request.outputs = outputs;
    request.when = FIRE3DV_IMAGE_EVERY_NTH;
    if (fire3dv_request_image(stream, &request, &ids.emplace_back()) != FIRE3DV_OK)
      return client_error("request");
  }
  return ids;
}

Result<void> measure(fire3dv_stream* stream, const CamerasOptions& options, const scene::Scene& scene,
                     uint32_t count, uint32_t outputs) {
  const float aspect = static_cast<float>(options.draw.width) / static_cast<float>(options.draw.height);
  auto ids = ask(stream, options, circle_of_cameras(scene, count, aspect), outputs);
  if (!ids) return ids.error();
  std::vector<double> seconds;
  uint64_t seen = 0, lost = 0, digest = 0xcbf29ce484222325;
  const float pose[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  for (uint32_t frame = 0; frame < options.warm_up + options.frames; ++frame) {
    const int64_t begin_ns = fire3dv::monotonic_ns();
    if (fire3dv_publish(stream, begin_ns, pose, 1, 0) != FIRE3DV_OK) return client_error("publish");
    for (const uint64_t id : *ids) {
      fire3dv_image* image = nullptr;
      if (fire3dv_wait_image(stream, id, kWaitMs, &image) != FIRE3DV_OK) return client_error("image");
      seen += look_at(*image);
      if (frame == 0) digest = digest_of(digest, *image);
      lost += image->lost;
      fire3dv_release_image(&image);
    }
    if (frame >= options.warm_up)
      seconds.push_back(static_cast<double>(fire3dv::monotonic_ns() - begin_ns) * 1e-9);
  }
  for (const uint64_t id : *ids) fire3dv_cancel_image(stream, id);
  if (seen == 0) return Error{"the images are blank, so no time is reported"};
  const Summary summary = summarise(seconds);
  std::printf("| %u | %ux%u | %s | %.3f | %.0f | %llu | %016llx |\n", count, options.draw.width,
              options.draw.height, options.outputs.c_str(), 1e3 * summary.median, count / summary.median,
              static_cast<unsigned long long>(lost), static_cast<unsigned long long>(digest));
  std::fflush(stdout);
  return {};
}

}  // namespace

Result<void> measure_served(const CamerasOptions& options) {
  Result<wire::ImageOutputs> outputs = wire::parse_image_outputs(options.outputs);
  if (!outputs) return Error{"--outputs: " + outputs.error().message};
  Result<scene::Scene> scene = scene::load_gltf(options.scene);
  if (!scene) return scene.error();
  Result<Stream> stream = open_stream(options.to);
  if (!stream) return stream.error();
  std::printf(
      "| cameras | size | outputs | ms for all | images a second | lost | digest |\n"
      "|---|---|---|---|---|---|---|\n");
  for (const uint32_t cameras : options.cameras) {
    if (Result<void> done = measure(stream->get(), options, *scene, cameras, outputs->bits()); !done)
      return done;
  }
  return {};
}

}  // namespace fire3dv::bench
