// Image latency of one glTF file, as benchmarks of other programs measure it: objects rotate, and each image
// is waited for.
#include <algorithm>
#include <cstdio>
#include <glm/gtc/matrix_transform.hpp>

#include "base/clock.h"
#include "base/command_line.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/sinks/png.h"
#include "tools/lab/bench/bench_device.h"
#include "tools/lab/bench/frames/frame_bench.h"
#include "tools/lab/bench/frames/frame_commands.h"
#include "tools/lab/bench/report/statistics.h"

namespace fire3dv::bench {
namespace {

constexpr float kImageTurnRadPerStep = 0.05f;

// Returns nodes with a mesh and a unique name, except the first: scenes begin with their ground.
std::vector<uint32_t> moving_nodes(const scene::Scene& scene) {
  const state::NodeNames names(scene);
  std::vector<uint32_t> nodes;
  bool ground_seen = false;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    if (scene.nodes[n].mesh == scene::kNone) continue;
    if (std::exchange(ground_seen, true) && names.find(scene.nodes[n].name) == n) nodes.push_back(n);
  }
  return nodes;
}

PoseFeed::PoseAt turning(const scene::Scene& scene, const std::vector<uint32_t>& nodes) {
  return [&scene, nodes](uint64_t step, std::vector<wire::Affine3x4>& poses) {
    poses.resize(nodes.size());
    const float angle = kImageTurnRadPerStep * static_cast<float>(step);
    for (size_t i = 0; i < nodes.size(); ++i) {
      const glm::mat4 turned = glm::rotate(scene.nodes[nodes[i]].world_from_node, angle, glm::vec3(0, 1, 0));
      for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column)
          poses[i].m[static_cast<size_t>(row * 4 + column)] = turned[column][row];
    }
  };
}

// Detects a renderer that draws nothing, whose times would be meaningless.
bool is_blank(const sinks::FrameImage& image) {
  const uint8_t* const first = image.rgba8.data();
  for (size_t p = 0; p < image.rgba8.size(); p += 4) {
    if (!std::equal(first, first + 3, first + p)) return false;
  }
  return true;
}

Result<void> measure_images(const ImageOptions& options) {
  const int64_t begin_ns = fire3dv::monotonic_ns();
  Result<scene::Scene> scene = scene::load_gltf(options.scene);
  if (!scene) return scene.error();
  Result<OpenDevice> open = open_device(options.draw);
  if (!open) return open.error();
  const std::vector<uint32_t> nodes = moving_nodes(*scene);
  if (nodes.empty())
    return Error{options.scene.string() + ": no node with a mesh and a name that could be moved"};
  settings::DrawSettings settings = options.draw.settings;
  const size_t textures = scene->textures.size();
  if (textures > gpu::BindlessTextures::most(*open->device)) {
    return Error{options.scene.string() + " has " + std::to_string(textures) + " textures, more than " +
                 open->device->report().name +
                 " takes: split the file, or choose another device with --device"};
  }
  settings.max_textures = std::max(settings.max_textures, static_cast<uint32_t>(textures));
  std::vector<std::string> names;
  for (const uint32_t node : nodes) names.push_back(scene->nodes[node].name);
  {
    Result<std::unique_ptr<FrameBench>> bench =
        FrameBench::open(*open->device, *scene, names, turning(*scene, nodes), settings,
                         {options.draw.width, options.draw.height});
    if (!bench) return bench.error();
    const Condition condition{"images", settings.cull, true, settings.levels_of_detail};
    const Result<sinks::FrameImage> first = (*bench)->draw(condition);
    if (!first) return first.error();
    const double setup_s = static_cast<double>(fire3dv::monotonic_ns() - begin_ns) * 1e-9;
    if (is_blank(*first))
      return Error{options.scene.string() + ": the image is blank, so no time is reported"};
    const Result<std::vector<double>> times =
        (*bench)->measure_images(condition, options.warm_up, options.frames);
    if (!times) return times.error();
    const Summary summary = summarise(*times);
    const passes::SceneRenderer& renderer = (*bench)->renderer();
    std::printf(
        "| FIRE-3DV | %s | %s, %u samples, shadows: %s, FXAA %s | %ux%u | %zu | %.2f | %.2f | %.2f | %.1f "
        "| %.2f |\n",
        options.scene.stem().c_str(),
        renderer.settings().raster_path() == settings::RasterPath::visibility ? "visibility" : "forward",
        static_cast<uint32_t>(renderer.settings().samples()),
        passes::describe(renderer.settings().shadow_technique()), settings.post.fxaa ? "on" : "off",
        options.draw.width, options.draw.height, summary.count, summary.median, summary.p95, summary.least,
        1000 / summary.median, setup_s);
    if (!options.png.empty()) {
      const Result<sinks::FrameImage> last = (*bench)->draw(condition);
      if (!last) return last.error();
      if (Result<void> written = sinks::write_png(options.png, *last); !written) return written;
    }
  }
  return open->finish();
}

}  // namespace

void add_image_options(CLI::App& app, ImageOptions& options) {
  options.draw.resolution = "640x480";
  add_draw_options(app, options.draw);
  app.add_option("scene", options.scene, "glTF 2.0 scene (.glb or .gltf)")->required();
  OptionGroup group(app);
  group.add("--frames", options.frames, "N", "timed images")->check(in_range(1, 100'000));
  group.add("--warm-up", options.warm_up, "N", "untimed images before them")->check(in_range(0, 100'000));
  group.add("--png", options.png, "FILE", "write the last image to this file");
}

int run_images(const ImageOptions& options) {
  const Result<void> measured = measure_images(options);
  if (measured) return 0;
  std::fprintf(stderr, "fire3dv-bench: %s\n", measured.error().message.c_str());
  return 1;
}

}  // namespace fire3dv::bench
