#include "tools/lab/bench/frames/frame_commands.h"

#include <charconv>
#include <cstdio>
#include <ctime>

#include "base/clock.h"
#include "base/command_line.h"
#include "renderer/app/options/drawing_options.h"
#include "renderer/app/options/option_values.h"
#include "renderer/passes/ray_effects/ray_effects_pass.h"
#include "renderer/sinks/png.h"
#include "tools/lab/bench/bench_device.h"
#include "tools/lab/bench/bench_scene.h"
#include "tools/lab/bench/report/build_info.h"
#include "tools/lab/bench/report/report.h"

namespace fire3dv::bench {

namespace {

constexpr uint64_t kMaxTriangles = 200'000'000;

}  // namespace

void add_draw_options(CLI::App& app, DrawOptions& options) {
  OptionGroup group(app, "Drawing");
  group.add("--resolution", options.resolution, "WxH", "image size in pixels");
  group.add("--device", options.device, "DEVICE",
            "Vulkan device: index, name, cuda:N, uuid:HEX, pci:ADDRESS");
  group.add_flag("--require-gpu", options.require_gpu, "exit with status 3 rather than draw on the CPU");
  group.add_choice("--async-compute", options.async_compute, "auto|on|off",
                   "build acceleration structures on an async queue");
  group.add_flag("--validation,!--no-validation", options.validation,
                 "Vulkan validation; a finding is an error");
  for (const settings::SettingGroup settings :
       {settings::SettingGroup::image, settings::SettingGroup::raster})
    app::add_draw_settings(app, settings::kByBench, settings, "Drawing", options.settings);
}

Result<void> check_draw_options(DrawOptions& options) {
  if (!app::parse_image_size(options.resolution, options.width, options.height)) {
    return Error{"--resolution " + options.resolution + ": must be WxH with sides of 1 to " +
                 std::to_string(app::kMaxImageSide) + ", such as 1920x1080"};
  }
  return {};
}

gpu::AsyncCompute async_compute(const DrawOptions& options) {
  if (options.async_compute == "on") return gpu::AsyncCompute::on;
  return options.async_compute == "off" ? gpu::AsyncCompute::off : gpu::AsyncCompute::automatic;
}

void add_frame_options(CLI::App& app, FrameOptions& options) {
  add_draw_options(app, options.draw);
  OptionGroup scene(app, "Scenes"), run(app, "Measurement"), output(app, "Output");
  scene.add("--sizes", options.sizes, "LIST", "triangles of the scenes");
  scene.add("--bodies", options.bodies, "N", "moving bodies; 0: more in larger scenes")
      ->check(in_range(0, 100'000));
  scene.add("--lights", options.lights, "N", "lights with shadows")->check(in_range(0, 16));
  scene.add("--texture-size", options.texture_side, "N", "side of the textures in pixels; 0: none")
      ->check(in_range(0, 4096));
  run.add("--frames", options.frames, "N", "timed frames per row")->check(in_range(1, 100'000));
  run.add("--warm-up", options.warm_up, "N", "untimed frames before them")->check(in_range(1, 100'000));
  run.add_choice("--conditions", options.conditions, "all|product|paper|rays",
                 "product, paper, all (both) or rays (ray effects)")
      ->type_name("NAME");
  run.add("--ray-effect-rays", options.ray_effect_rays, "N", "rays of an effect in a pixel")
      ->check(in_range(1, 16));
  run.add_flag("--gui", options.gui, "draw the window's panels over the images");
  run.add("--gui-scale", options.gui_scale, "X", "scale of the panels")->check(number_between(0.5, 4));
  output.add("--out", options.out, "DIR", "folder of table and CSV file");
  output.add("--name", options.name, "NAME", "their file name without ending");
  output.add("--image", options.images, "DIR", "folder for a PNG of each scene");
}

Result<void> check_frame_options(FrameOptions& options) {
  if (Result<void> checked = check_draw_options(options.draw); !checked) return checked;
  options.triangles.clear();
  std::string_view rest = options.sizes;
  while (true) {
    const size_t comma = rest.find(',');
    Result<uint64_t> triangles = parse_triangles(rest.substr(0, comma));
    if (!triangles) return Error{"--sizes " + options.sizes + ": " + triangles.error().message};
    options.triangles.push_back(*triangles);
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  if (options.name.empty() || options.name.find('/') != std::string::npos || options.name.starts_with('.'))
    return Error{"--name " + options.name + ": must be a file's name, without folder and ending"};
  return {};
}

Result<uint64_t> parse_triangles(std::string_view text) {
  uint64_t number = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  const std::string_view unit(stop, static_cast<size_t>(end - stop));
  const uint64_t factor = unit == "M" ? 1'000'000 : unit == "K" ? 1'000 : unit.empty() ? 1 : 0;
  constexpr uint64_t kFewest = 1'000;
  if (error != std::errc() || factor == 0 || number > kMaxTriangles || number * factor > kMaxTriangles ||
      number * factor < kFewest) {
    return Error{"\"" + std::string(text) + "\" must be a number of triangles from 1K to 200M"};
  }
  return number * factor;
}

std::string triangles_text(uint64_t triangles) {
  if (triangles % 1'000'000 == 0) return std::to_string(triangles / 1'000'000) + "M";
  if (triangles % 1'000 == 0) return std::to_string(triangles / 1'000) + "K";
  return std::to_string(triangles);
}

namespace {

double seconds_since(int64_t begin_ns) {
  return static_cast<double>(fire3dv::monotonic_ns() - begin_ns) * 1e-9;
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[16];
  std::strftime(text, sizeof text, "%Y-%m-%d", &utc);
  return text;
}

Result<void> make_folder(const char* option, const std::filesystem::path& folder) {
  std::error_code error;
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (!error) return {};
  return Error{std::string(option) + " " + folder.string() +
               ": the folder cannot be made: " + error.message() + "; choose another"};
}

std::vector<Condition> conditions_of(const FrameOptions& options) {
  std::vector<Condition> conditions;
  const settings::DrawSettings product = options.draw.settings;
  if (options.conditions != "paper") {
    conditions.push_back({kProduct, product.cull, true, product.levels_of_detail});
    conditions.push_back({kProductMain, product.cull, false, product.levels_of_detail});
  }
  if (options.conditions == "rays") {
    for (const char* name : kRayConditions) {
      Condition condition{name, product.cull, true, product.levels_of_detail};
      FIRE3DV_ASSERT(settings::ray_effects_named(name, condition.ray_effects));
      conditions.push_back(condition);
    }
    return conditions;
  }
  if (options.conditions != "product") {
    conditions.push_back({kPaper, settings::Cull::off, true, settings::LevelsOfDetail::off});
    conditions.push_back({kPaperMain, settings::Cull::off, false, settings::LevelsOfDetail::off});
  }
  return conditions;
}

Report describe_run(const FrameOptions& options, const gpu::Device& device) {
  Report report;
  report.command = options.command;
  report.commit = kCommit;
  report.date = today();
  report.device = device.report().name;
  report.driver = device.report().driver;
  report.width = options.draw.width;
  report.height = options.draw.height;
  report.lights = options.lights;
  report.texture_side = options.texture_side;
  report.warm_up = options.warm_up;
  report.frames = options.frames;
  report.fxaa = options.draw.settings.post.fxaa;
  return report;
}

// Records the settings that the device selected.
void describe_drawing(const passes::SceneRenderer& renderer, Report& report) {
  report.samples = static_cast<uint32_t>(renderer.settings().samples());
  report.raster = renderer.settings().raster_path() == settings::RasterPath::visibility
                      ? "from a visibility buffer"
                      : "forward";
  report.shadows = passes::describe(renderer.settings().shadow_technique());
}

void say(const RunSummary& run) {
  std::fprintf(stderr, "  %-20s whole frame %9.3f ms  p95 %9.3f  CPU %7.3f  pose age %7.3f |",
               run.condition.c_str(), run.frame_ms.median, run.frame_ms.p95, run.cpu_ms.median,
               run.pose_age_ms.median);
  for (size_t s = 0; s < kStages; ++s) {
    if (run.stage_ms[s].most > 0)
      std::fprintf(stderr, " %s %.3f", stage_name(static_cast<Stage>(s)), run.stage_ms[s].median);
  }
  if (!run.shadows) std::fprintf(stderr, " | main pass %.3f", run.main_pass_ms.median);
  std::fprintf(stderr, "\n");
}

Result<SceneReport> measure_scene(const FrameOptions& options, gpu::Device& device, const Surfaces& surfaces,
                                  uint64_t triangles, Report& report) {
  const int64_t begin_ns = fire3dv::monotonic_ns();
  const BenchScene made =
      make_bench_scene({triangles, options.bodies, options.lights}, surfaces,
                       static_cast<float>(options.draw.width) / static_cast<float>(options.draw.height));
  SceneReport scene;
  scene.name = triangles_text(triangles);
  scene.triangles = made.triangles;
  scene.unique_triangles = made.unique_triangles;
  scene.bodies = static_cast<uint32_t>(made.bodies.size());
  scene.make_s = seconds_since(begin_ns);

  const auto pose_at = [&bodies = made.bodies](uint64_t step, std::vector<wire::Affine3x4>& poses) {
    pose_bodies(bodies, step, poses);
  };
  settings::DrawSettings settings = options.draw.settings;
  if (options.conditions == "rays") {
    FIRE3DV_ASSERT(settings::ray_effects_named("all", settings.ray_effects.on));
    settings.ray_effects.back_end = settings.shadows.back_end;
    settings.ray_effects.set_rays(options.ray_effect_rays);
    const bool has_visibility_buffer =
        settings.raster != settings::RasterPath::forward && device.report().int64_atomics;
    if (Result<void> can = passes::can_trace_ray_effects(device, has_visibility_buffer); !can)
      return Error{"--conditions rays: " + can.error().message};
  }
  Result<std::unique_ptr<FrameBench>> bench = FrameBench::open(
      device, made.scene, made.body_names, pose_at, settings, {options.draw.width, options.draw.height});
  if (!bench) return bench.error();
  if (options.gui) (*bench)->show_panels(options.gui_scale);
  scene.load_s = (*bench)->load_s();
  describe_drawing((*bench)->renderer(), report);
  std::fprintf(stderr, "%s: %llu triangles, %llu in memory, %u bodies, made in %.1f s, loaded in %.1f s\n",
               scene.name.c_str(), static_cast<unsigned long long>(scene.triangles),
               static_cast<unsigned long long>(scene.unique_triangles), scene.bodies, scene.make_s,
               scene.load_s);

  const std::vector<Condition> conditions = conditions_of(options);
  if (!options.images.empty()) {
    const Result<sinks::FrameImage> image = (*bench)->draw(conditions.front());
    if (!image) return image.error();
    const std::filesystem::path path = options.images / (options.name + "-" + scene.name + ".png");
    if (Result<void> written = sinks::write_png(path, *image); !written) return written.error();
  }
  for (const Condition& condition : conditions) {
    const Result<FrameSamples> samples = (*bench)->measure(condition, options.warm_up, options.frames);
    if (!samples) return samples.error();
    scene.runs.push_back(summarise_run(condition, *samples));
    say(scene.runs.back());
  }
  return scene;
}

Result<void> measure_all(const FrameOptions& options) {
  // Cheap checks come first.
  if (Result<void> made = make_folder("--out", options.out); !made) return made;
  if (Result<void> made = make_folder("--image", options.images); !made) return made;
  Result<OpenDevice> open = open_device(options.draw);
  if (!open) return open.error();
  Report report = describe_run(options, *open->device);
  const Surfaces surfaces = make_surfaces(options.texture_side);
  for (const uint64_t triangles : options.triangles) {
    Result<SceneReport> scene = measure_scene(options, *open->device, surfaces, triangles, report);
    if (!scene) return scene.error();
    report.scenes.push_back(std::move(*scene));
    open->device->retire_all_now();
    // Written after each scene, so that an interrupted run keeps its results.
    if (Result<void> written = write_report(report, options.out, options.name); !written) return written;
  }
  return open->finish();
}

}  // namespace

int run_frames(const FrameOptions& options) {
  const Result<void> measured = measure_all(options);
  if (!measured) {
    std::fprintf(stderr, "fire3dv-bench: %s\n", measured.error().message.c_str());
    return 1;
  }
  std::printf("%s\n", (options.out / (options.name + ".md")).c_str());
  return 0;
}

}  // namespace fire3dv::bench
