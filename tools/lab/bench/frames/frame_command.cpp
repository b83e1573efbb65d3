#include "tools/lab/bench/frames/frame_commands.h"

#include <cstdio>
#include <ctime>

#include "protocol/base/clock.h"
#include "renderer/sinks/png.h"
#include "tools/lab/bench/bench_device.h"
#include "tools/lab/bench/bench_scene.h"
#include "tools/lab/bench/report/build_info.h"
#include "tools/lab/bench/report/report.h"

namespace fire3dv::bench {
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
  const passes::DrawSettings product = draw_settings(options.draw);
  if (options.conditions != "paper") {
    conditions.push_back({kProduct, product.cull, true, product.levels_of_detail});
    conditions.push_back({kProductMain, product.cull, false, product.levels_of_detail});
  }
  if (options.conditions != "product") {
    conditions.push_back({kPaper, passes::Cull::off, true, passes::LevelsOfDetail::off});
    conditions.push_back({kPaperMain, passes::Cull::off, false, passes::LevelsOfDetail::off});
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
  report.on_cpu = device.report().type == gpu::DeviceType::software;
  report.width = options.draw.width;
  report.height = options.draw.height;
  report.lights = options.lights;
  report.texture_side = options.texture_side;
  report.warm_up = options.warm_up;
  report.frames = options.frames;
  report.fxaa = options.draw.fxaa == "on";
  return report;
}

// Records the settings that the device selected.
void describe_drawing(const passes::SceneRenderer& renderer, Report& report) {
  report.samples = static_cast<uint32_t>(renderer.samples());
  report.raster =
      renderer.raster_path() == passes::RasterPath::visibility ? "from a visibility buffer" : "forward";
  report.shadows = passes::describe(renderer.shadow_technique());
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
  Result<std::unique_ptr<FrameBench>> bench =
      FrameBench::open(device, made.scene, made.body_names, pose_at, draw_settings(options.draw),
                       {options.draw.width, options.draw.height});
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
