#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "base/command_line.h"
#include "base/plural.h"
#include "fire3dv/batch.h"
#include "fire3dv/client.h"
#include "fire3dv/image.h"
#include "protocol/wire/image_outputs.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/readback_ring.h"
#include "renderer/passes/outputs/planes_and_boxes.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/passes/view/view.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tools/lab/bench/bench_device.h"
#include "tools/lab/bench/bench_scene.h"
#include "tools/lab/bench/frames/frame_commands.h"
#include "tools/lab/bench/frames/world_poses.h"
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

// Opens a stream that describes these nodes, and waits for a renderer.
Result<Stream> open_stream(const std::string& uri, const std::vector<std::string>& names) {
  fire3dv_options options{};
  options.struct_size = sizeof(options);
  options.adapter_name = "bench";
  Stream stream(fire3dv_open(uri.c_str(), &options));
  if (!stream) return client_error("--to");
  std::vector<const char*> name_pointers;
  for (const std::string& name : names) name_pointers.push_back(name.c_str());
  fire3dv_description description{};
  description.struct_size = sizeof(description);
  description.node_names = name_pointers.data();
  description.node_count = name_pointers.size();
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

// Rows of a pose.
std::array<float, 12> rows_of(const glm::mat4& matrix) {
  std::array<float, 12> rows{};
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      rows[static_cast<size_t>(row * 4 + column)] = matrix[column][row];
  return rows;
}

// One batch a round: poses of all worlds, and the images of all cameras.
Result<void> measure_batch(fire3dv_stream* stream, const CamerasOptions& options, const scene::Scene& scene,
                           WorldPoses& worlds, uint32_t count, uint32_t outputs) {
  const float aspect = static_cast<float>(options.draw.width) / static_cast<float>(options.draw.height);
  const passes::Intrinsics lens =
      passes::intrinsics_of(scene::Camera(), {options.draw.width, options.draw.height});
  std::vector<std::array<float, 12>> cameras;
  std::vector<uint32_t> world_of_view;
  for (const glm::mat4& world_from_camera : circle_of_cameras(scene, count, aspect)) {
    world_of_view.push_back(static_cast<uint32_t>(cameras.size()) % options.worlds);
    cameras.push_back(rows_of(world_from_camera));
  }
  fire3dv_batch_request request{};
  request.struct_size = sizeof(request);
  request.worlds = request.pose_worlds = options.worlds;
  request.poses = worlds.poses()[0].m.data();
  request.world_of_view = world_of_view.data();
  request.views = request.pose_views = count;
  request.parent_from_camera = cameras[0].data();
  request.width = options.draw.width;
  request.height = options.draw.height;
  request.fx = lens.fx_px;
  request.fy = lens.fy_px;
  request.cx = lens.cx_px;
  request.cy = lens.cy_px;
  request.near_m = lens.near_m;
  request.outputs = outputs;
  std::vector<double> seconds;
  uint64_t seen = 0, digest = 0;
  for (uint32_t frame = 0; frame < options.warm_up + options.frames; ++frame) {
    worlds.simulate(frame);
    const int64_t begin_ns = fire3dv::monotonic_ns();
    uint64_t id = 0;
    fire3dv_image* images = nullptr;
    if (fire3dv_request_batch(stream, &request, &id) != FIRE3DV_OK) return client_error("batch");
    if (fire3dv_wait_image(stream, id, kWaitMs, &images) != FIRE3DV_OK) return client_error("batch");
    seen += look_at(*images);
    const double s = static_cast<double>(fire3dv::monotonic_ns() - begin_ns) * 1e-9;
    if (frame == 0) digest = digest_of(0xcbf29ce484222325, *images);
    fire3dv_release_image(&images);
    if (frame >= options.warm_up) seconds.push_back(s);
  }
  if (seen == 0) return Error{"the images are blank, so no time is reported"};
  const Summary summary = summarise(seconds);
  std::printf("| %u | %u | %ux%u | %s | %.3f | %.0f | %016llx |\n", count, options.worlds, options.draw.width,
              options.draw.height, options.outputs.c_str(), 1e3 * summary.median, count / summary.median,
              static_cast<unsigned long long>(digest));
  std::fflush(stdout);
  return {};
}

Result<void> measure_batches(const CamerasOptions& options, const scene::Scene& scene, uint32_t outputs) {
  WorldPoses worlds(scene, options.worlds);
  if (worlds.bodies() == 0)
    return Error{"--worlds: no node of the scene has a mesh, so that its worlds would be alike"};
  Result<Stream> stream = open_stream(options.to, worlds.names());
  if (!stream) return stream.error();
  std::printf(
      "| cameras | worlds | size | outputs | ms for all | images a second | digest |\n"
      "|---|---|---|---|---|---|---|\n");
  for (const uint32_t cameras : options.cameras) {
    if (Result<void> done = measure_batch(stream->get(), options, scene, worlds, cameras, outputs); !done)
      return done;
  }
  return {};
}

}  // namespace

Result<void> measure_served(const CamerasOptions& options) {
  Result<wire::ImageOutputs> outputs = wire::parse_image_outputs(options.outputs);
  if (!outputs) return Error{"--outputs: " + outputs.error().message};
  Result<scene::Scene> scene = scene::load_gltf(options.scene);
  if (!scene) return scene.error();
  if (options.worlds > 1) return measure_batches(options, *scene, outputs->bits());
  Result<Stream> stream = open_stream(options.to, {"nothing of the scene"});
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

namespace {

std::vector<passes::View> around(const scene::Scene& scene, uint32_t count, uint32_t worlds, float aspect) {
  std::vector<passes::View> views;
  for (const glm::mat4& world_from_camera : circle_of_cameras(scene, count, aspect)) {
    views.push_back(passes::make_view(scene::Camera(), world_from_camera, aspect));
    views.back().world = static_cast<uint32_t>(views.size() - 1) % worlds;
  }
  return views;
}

// Returns the number of cameras per submission; the image height limits it.
uint32_t batch_of(const gpu::Device& device, uint32_t cameras, uint32_t height) {
  return std::clamp(device.limits().maxImageDimension2D / height, 1u, cameras);
}

struct Bench {
  gpu::Device& device;
  const scene::Scene& scene;
  VkExtent2D extent;
  wire::ImageOutputs outputs;
  passes::SceneRenderer renderer;
  gpu::FrameRing frames;
  gpu::ReadbackRing<int> readback;
  WorldPoses poses;
  uint64_t pixels_seen = 0;                             // sum over sampled foreground pixels
  std::vector<std::pair<std::string, double>> pass_ms;  // of timed rounds, with --passes

  Bench(gpu::Device& on, const scene::Scene& of, const CamerasOptions& options,
        const wire::ImageOutputs& wanted)
      : device(on),
        scene(of),
        extent{options.draw.width, options.draw.height},
        outputs(wanted),
        renderer(on, options.draw.settings),
        frames(on),
        readback(on),
        poses(of, options.worlds) {
    if (options.passes) frames.time(gpu::Timed::passes);
  }

  // Returns an error with the number of worlds that fit, if these do not.
  Result<void> set_worlds(uint32_t worlds) {
    for (uint32_t fitting = worlds; fitting > 0; fitting /= 2) {
      try {
        renderer.set_scene(scene, fitting);
        if (fitting == worlds) return {};
        return Error{"--worlds " + std::to_string(worlds) + ": the device has no memory for so many: take " +
                     std::to_string(fitting) + " or fewer"};
      } catch (const gpu::VulkanFailure& failure) {
        if (!gpu::is_out_of_memory(failure)) throw;
      }
    }
    return Error{"the device has no memory for the scene: take one with fewer triangles"};
  }

  // is_first: of a round, whose later submissions show the same poses.
  Result<void> submit(std::span<const passes::View> views, bool is_first, bool reads_back) {
    const Result<passes::PreparedFrame> prepared =
        renderer.prepare({.extent = extent,
                          .views = static_cast<uint32_t>(views.size()),
                          .outputs = outputs,
                          .scene = is_first ? passes::SceneUpdate::update : passes::SceneUpdate::reuse});
    if (!prepared) return prepared.error();
    gpu::Recorder& recorder = frames.begin();
    renderer.record(*prepared, recorder, frames.staging(), poses.worlds(), views);
    if (reads_back) {
      gpu::ReadbackRing<int>::Planes planes;
      if (outputs.has_planes()) planes = {&renderer.planes(), passes::bytes_of(renderer.plane_ranges())};
      readback.record(recorder, outputs.has(wire::kColorSrgb8) ? &renderer.image() : nullptr,
                      renderer.image().extent, planes, 0);
    }
    const uint64_t submitted = frames.submit();
    if (reads_back) readback.submitted(submitted);
    return {};
  }
  // Sums one byte per cache line, which proves that the whole image is in host memory.
  void take() {
    readback.poll([&](int, VkExtent2D, std::span<const uint8_t> bytes) {
      for (size_t i = 0; i < bytes.size(); i += 64) pixels_seen += bytes[i];
    });
  }
  void add_times(const gpu::FrameTimes& times) {
    for (const gpu::PassTime& pass : times.passes) {
      const auto same = [&](const auto& entry) { return entry.first == pass.name; };
      auto entry = std::find_if(pass_ms.begin(), pass_ms.end(), same);
      if (entry == pass_ms.end()) entry = pass_ms.insert(entry, {pass.name, 0});
      entry->second += pass.milliseconds;
    }
  }
};

Result<void> measure(Bench& bench, const CamerasOptions& options, uint32_t cameras) {
  if (Result<void> can = bench.renderer.can_take(bench.outputs, cameras); !can) return can;
  const float aspect = static_cast<float>(bench.extent.width) / static_cast<float>(bench.extent.height);
  const std::vector<passes::View> views = around(bench.scene, cameras, options.worlds, aspect);
  const uint32_t batch = batch_of(bench.device, cameras, bench.extent.height);
  std::vector<double> seconds;
  double gpu_ms = 0, cpu_ms = 0, publish_ms = 0;
  bench.pass_ms.clear();
  bench.pixels_seen = 0;
  for (uint32_t frame = 0; frame < options.warm_up + options.frames; ++frame) {
    if (options.worlds > 1) bench.poses.simulate(frame);
    const bool reads_back = !options.resident || frame == 0;  // blank images are errors
    const int64_t begin_ns = fire3dv::monotonic_ns();
    if (options.worlds > 1) {
      if (Result<void> published = bench.poses.publish(); !published) return published;
    }
    int64_t recorded_ns = 0;
    const int64_t published_ns = fire3dv::monotonic_ns();
    for (uint32_t first = 0; first < cameras; first += batch) {
      // The last batch overlaps the previous one, so that image sizes stay constant.
      const uint32_t from = std::min(first, cameras - batch);
      const int64_t piece_ns = fire3dv::monotonic_ns();
      if (Result<void> drawn = bench.submit(std::span(views).subspan(from, batch), first == 0, reads_back);
          !drawn)
        return drawn;
      recorded_ns += fire3dv::monotonic_ns() - piece_ns;
      bench.take();
    }
    bench.device.wait(bench.device.last_submitted());
    bench.take();
    const double s = static_cast<double>(fire3dv::monotonic_ns() - begin_ns) * 1e-9;
    const std::vector<gpu::FrameTimes> times = bench.frames.take_finished();
    if (frame < options.warm_up) continue;
    seconds.push_back(s);
    for (const gpu::FrameTimes& t : times) {
      gpu_ms += t.total_ms;
      bench.add_times(t);
    }
    cpu_ms += static_cast<double>(recorded_ns) * 1e-6;
    publish_ms += static_cast<double>(published_ns - begin_ns) * 1e-6;
  }
  if (bench.pixels_seen == 0) return Error{"the images are blank, so no time is reported"};
  if (const uint32_t without = bench.renderer.counts().lights_without_shadow; without > 0)
    std::fprintf(stderr, "warning: %s, for lack of memory: take fewer --worlds, or --shadows small-map\n",
                 (counted(without, "light") + (without == 1 ? " casts" : " cast") + " no shadow").c_str());
  const Summary summary = summarise(seconds);
  const double frames = static_cast<double>(options.frames);
  std::printf("| %u | %u | %u | %ux%u | %s | %s | %.3f | %.3f | %.3f | %.3f | %.0f |\n", cameras,
              options.worlds, batch, bench.extent.width, bench.extent.height, options.outputs.c_str(),
              options.resident ? "device" : "host", 1e3 * summary.median, gpu_ms / frames, cpu_ms / frames,
              publish_ms / frames, cameras / summary.median);
  for (const auto& [name, ms] : bench.pass_ms) std::printf("  %-16s %8.3f ms\n", name.c_str(), ms / frames);
  std::fflush(stdout);
  return {};
}

Result<void> measure_all(const CamerasOptions& options) {
  Result<wire::ImageOutputs> outputs = wire::parse_image_outputs(options.outputs);
  if (!outputs) return Error{"--outputs: " + outputs.error().message};
  if (!outputs->has(wire::kColorSrgb8) && !outputs->has_planes())
    return Error{"--outputs: name color or a plane"};
  Result<scene::Scene> scene = scene::load_gltf(options.scene);
  if (!scene) return scene.error();
  Result<OpenDevice> open = open_device(options.draw);
  if (!open) return open.error();
  {
    Bench bench(*open->device, *scene, options, *outputs);
    if (Result<void> fits = bench.set_worlds(options.worlds); !fits) return fits;
    if (options.worlds > 1 && bench.poses.bodies() == 0)
      return Error{"--worlds: no node of the scene has a mesh, so that its worlds would be alike"};
    std::printf(
        "| cameras | worlds | in one submission | size | outputs | images end in | ms for all | of that GPU "
        "| recording | publishing | images a second |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (const uint32_t cameras : options.cameras) {
      if (Result<void> measured = measure(bench, options, cameras); !measured) return measured;
    }
  }
  return open->finish();
}

}  // namespace

void add_cameras_options(CLI::App& app, CamerasOptions& options) {
  options.draw.resolution = "64x64";
  options.draw.settings.post.fxaa = false;
  options.draw.settings.shadows.method = settings::ShadowMethod::off;
  add_draw_options(app, options.draw);
  app.add_option("scene", options.scene, "glTF 2.0 scene (.glb or .gltf)")->required();
  OptionGroup group(app);
  group.add("--cameras", options.cameras, "LIST", "numbers of cameras (default: 1,8,64)")
      ->delimiter(',')
      ->check(in_range(1, 100'000));
  group.add("--to", options.to, "URI", "request the images from a fire3dv --lockstep at this URI");
  group.add("--outputs", options.outputs, "LIST", "outputs of each image, as fire3dv --outputs");
  group.add("--worlds", options.worlds, "N", "copies with random poses; camera i shows i modulo N")
      ->check(in_range(uint32_t{1}, passes::kMaxWorlds));
  group.add_flag("--resident", options.resident, "leave the images on the device");
  group.add_flag("--passes", options.passes, "print the GPU time of each pass, which slows the passes");
  group.add("--frames", options.frames, "N", "timed rounds")->check(in_range(1, 100'000));
  group.add("--warm-up", options.warm_up, "N", "untimed rounds before them")->check(in_range(0, 100'000));
}

int run_cameras(const CamerasOptions& options) {
  const bool is_in_process = options.resident || options.passes;
  Result<void> measured;
  if (options.resident && options.warm_up == 0) {
    measured = Error{
        "--resident --warm-up 0: the first round reads its images back, to see that they are not blank, and "
        "is not timed: take --warm-up 1 or more"};
  } else if (options.to.empty()) {
    measured = measure_all(options);
  } else if (is_in_process) {
    measured = Error{"--resident and --passes measure images of this process: leave --to out"};
  } else {
    measured = measure_served(options);
  }
  if (measured) return 0;
  std::fprintf(stderr, "fire3dv-bench: %s\n", measured.error().message.c_str());
  return 1;
}

}  // namespace fire3dv::bench
