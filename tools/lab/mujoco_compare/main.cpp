// Comparison of MuJoCo's own renderer with FIRE-3DV's images: fire3dv-mujoco-compare MODEL.xml --to URI.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "adapters/mujoco/options.h"
#include "base/command_line.h"
#include "renderer/sinks/png.h"
#include "tools/lab/mujoco_compare/labels.h"
#include "tools/lab/mujoco_compare/renderers.h"

namespace fire3dv::mujoco {
namespace {

// Command line of fire3dv-mujoco-compare.
struct CompareOptions {
  std::string model, uri;
  MujocoView view;
  bool speed = false;
  int frames = 8;                  // agreement: frames in total; speed: frames per block
  int blocks = 7;                  // speed: blocks per renderer, interleaved
  double every_s = 0.25;           // agreement: simulated seconds between frames
  double timeout_s = 60;           // per image
  std::filesystem::path pictures;  // agreement: folder for image pairs; empty: none
};

// Time of a step with colour, depth and labels in both renderers. Blocks alternate, so that other load on the
// machine affects both.
struct Speed {
  double ours_ms = 0, theirs_ms = 0;  // median of a step with its images
  double ratio = 0;                   // median over blocks of theirs / ours
  double lowest = 0, highest = 0;     // range of these ratios
};

// Returns nothing when the program must exit with *exit_code: 0 after --help, 2 after a usage error. The text
// has been printed.
std::optional<CompareOptions> parse_compare_options(int argc, char** argv, int* exit_code) {
  CompareOptions options;
  std::string images = "free camera:640x480";
  CLI::App app{"Compares images and step times of FIRE-3DV and MuJoCo's offscreen renderer.",
               "fire3dv-mujoco-compare"};
  set_help(app, "MODEL.xml --to URI [OPTIONS]");
  set_program_flags(app);
  app.footer(
      "Exit status: 0 done, 1 error, 2 wrong usage, 77 no OpenGL without a display.\n"
      "Details: man fire3dv-mujoco-compare.");
  fire3dv::OptionGroup group(app), pictures(app, "Images"), speeds(app, "Speed");
  app.add_option("model", options.model, "MJCF file")->required();
  group.add("--to", options.uri, "URI", "URI of a fire3dv --headless --on-request")->required();
  group.add("--timeout", options.timeout_s, "SECONDS", "limit of the wait for one image")
      ->check(number_between(0.1, 86400));
  pictures.add("--images", images, "CAMERA[:WxH]", "camera and image size");
  pictures.add("--frames", options.frames, "N", "compared images; with --speed, images per round")
      ->check(number_between(1, 1e6));
  CLI::Option* const speed =
      speeds.add_flag("--speed", options.speed, "time steps with images, alternately with MuJoCo");
  pictures.add("--every", options.every_s, "SECONDS", "simulated time between compared images")
      ->excludes(speed)
      ->check(check_number);
  bool no_reflections = false;
  pictures.add_flag("--no-reflections", no_reflections, "no reflections of MuJoCo's floors");
  pictures.add("--pictures", options.pictures, "DIR", "folder for both images side by side")->excludes(speed);
  speeds.add("--blocks", options.blocks, "N", "rounds")->needs(speed)->check(number_between(1, 1e6));
  speeds.add("--samples", options.view.samples, "N", "MuJoCo's samples per pixel")
      ->needs(speed)
      ->check(number_between(0, 16));
  speeds
      .add("--shadow-texels", options.view.shadow_texels, "N", "side of MuJoCo's shadow maps; 0: no shadows")
      ->needs(speed)
      ->check(number_between(0, 16384));
  try {
    app.parse(argc, argv);
    const Result<ImageSpec> spec = image_spec(images);
    if (!spec) throw CLI::ValidationError("--images", spec.error().message);
    options.view.camera = spec->camera;
    options.view.width = spec->width;
    options.view.height = spec->height;
    options.view.reflections = !no_reflections;
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error, std::cout, std::cerr) == 0 ? 0 : 2;
    return std::nullopt;
  }
  return options;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Returns the median time of `frames` calls of `frame`, in milliseconds. `frame` steps the simulation and
// draws once.
template <typename Frame>
Result<double> block_ms(int frames, std::vector<double>& all, Frame&& frame) {
  std::vector<double> times;
  for (int i = 0; i < frames; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    if (Result<void> done = frame(); !done) return done.error();
    times.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
  }
  all.insert(all.end(), times.begin(), times.end());
  return median(times);
}

Result<Speed> measure_speed(Simulation& simulation, RequestedImages& ours, MujocoRenderer& theirs, int blocks,
                            int frames) {
  std::vector<double> our_times, their_times, ratios;
  const auto our_frame = [&]() -> Result<void> {
    if (Result<void> done = simulation.step(); !done) return done;
    const Result<Image> image = ours.draw(simulation);
    return image ? Result<void>{} : Result<void>(image.error());
  };
  const auto their_frame = [&]() -> Result<void> {
    if (Result<void> done = simulation.step(); !done) return done;
    if (Result<void> done = theirs.draw_color_and_depth(simulation.data()); !done) return done;
    return theirs.draw_labels(simulation.data());
  };
  constexpr int kWarmUp = 3;  // frames for shader compilation and memory allocation
  std::vector<double> unused;
  if (auto warm = block_ms(kWarmUp, unused, our_frame); !warm) return warm.error();
  if (auto warm = block_ms(kWarmUp, unused, their_frame); !warm) return warm.error();
  for (int block = 0; block < blocks; ++block) {
    const Result<double> mine = block_ms(frames, our_times, our_frame);
    if (!mine) return mine.error();
    const Result<double> other = block_ms(frames, their_times, their_frame);
    if (!other) return other.error();
    ratios.push_back(*other / *mine);
  }
  const auto [lowest, highest] = std::minmax_element(ratios.begin(), ratios.end());
  return Speed{median(our_times), median(their_times), median(ratios), *lowest, *highest};
}

constexpr int kFailed = 1, kNoOpenGl = 77;  // exit status of skipped tests

void log_line(const std::string& text) {
  std::fprintf(stderr, "fire3dv-mujoco-compare: %s\n", text.c_str());
}

// Counts steps instead of reading the time, which MuJoCo restarts when it resets an unstable simulation.
Result<void> step(Simulation& simulation, double seconds) {
  constexpr double kMaxSteps = 1e9;
  const double steps = seconds / simulation.model().opt.timestep;
  if (!(steps < kMaxSteps))
    return Error{std::to_string(seconds) + " s are too many steps of " +
                 std::to_string(simulation.model().opt.timestep) + " s: choose a smaller --every"};
  for (double taken = 0; taken + 0.5 < steps; ++taken)
    if (Result<void> done = simulation.step(); !done) return done;
  return simulation.update_poses();
}

// Writes FIRE-3DV's image left, MuJoCo's right.
Result<void> write_pair(const std::filesystem::path& file, const MujocoView& view,
                        const std::vector<uint8_t>& ours, const std::vector<uint8_t>& theirs) {
  sinks::FrameImage pair;
  pair.width = 2 * view.width;
  pair.height = view.height;
  for (size_t y = 0; y < view.height; ++y) {
    for (const auto* rgb : {&ours, &theirs}) {
      for (size_t x = 0; x < view.width; ++x) {
        const uint8_t* pixel = &(*rgb)[3 * (y * view.width + x)];
        pair.rgba8.insert(pair.rgba8.end(), {pixel[0], pixel[1], pixel[2], 255});
      }
    }
  }
  return sinks::write_png(file, pair);
}

Result<void> agree(const CompareOptions& options, Simulation& simulation, RequestedImages& ours,
                   MujocoRenderer& theirs) {
  if (!options.pictures.empty()) std::filesystem::create_directories(options.pictures);
  Agreement agreement(endless_planes(simulation.model()));
  for (int frame = 0; frame < options.frames; ++frame) {
    if (Result<void> done = step(simulation, frame ? options.every_s : 0); !done) return done;
    const Result<Image> image = ours.draw(simulation);
    if (!image) return image.error();
    const Result<LabelledDepth> mine = ours.labelled(**image);
    if (!mine) return mine.error();
    LabelledDepth other{mine->width, mine->height, {}, {}};
    if (Result<void> drawn = theirs.draw_color_and_depth(simulation.data()); !drawn) return drawn;
    other.depths_m = theirs.depths_m();
    if (!options.pictures.empty()) {
      const auto file = options.pictures / ("frame_" + std::to_string(frame) + ".png");
      Result<void> kept =
          write_pair(file, options.view, RequestedImages::rgb(**image), theirs.upright_color());
      if (!kept) return kept;
    }
    if (Result<void> drawn = theirs.draw_labels(simulation.data()); !drawn) return drawn;
    other.labels = theirs.labels();
    agreement.add(*mine, other, theirs.far_m());
  }
  std::printf("| %s | %s | %ux%u | %d | %llu | %.2f | %.3f | %.4f | %.1e | %.1e | %.1e |\n",
              std::filesystem::path(options.model).stem().c_str(), options.view.camera.c_str(),
              options.view.width, options.view.height, options.frames,
              static_cast<unsigned long long>(agreement.objects()), 100 * agreement.beyond_floor_share(),
              100 * agreement.same_share(), 100 * agreement.same_share_off_edges(),
              agreement.depth_error(0.5), agreement.depth_error(0.99), agreement.depth_error(0.999));
  return {};
}

Result<void> speed(const CompareOptions& options, Simulation& simulation, RequestedImages& ours,
                   MujocoRenderer& theirs) {
  const Result<Speed> found = measure_speed(simulation, ours, theirs, options.blocks, options.frames);
  if (!found) return found.error();
  std::printf("| %s | %ux%u | %s | %d | %.2f | %.2f | %.2f (%.2f to %.2f) |\n",
              std::filesystem::path(options.model).stem().c_str(), options.view.width, options.view.height,
              options.view.shadow_texels ? std::to_string(options.view.shadow_texels).c_str() : "off",
              options.view.samples, found->ours_ms, found->theirs_ms, found->ratio, found->lowest,
              found->highest);
  return {};
}

Result<void> run(const CompareOptions& options) {
  Result<Simulation> simulation =
      Simulation::load(options.model, "", options.speed ? Drive::hold : Drive::sine);
  if (!simulation) return simulation.error();
  MujocoView view = options.view;
  if (!options.speed) view.fine = true, view.samples = 0, view.shadow_texels = 0;
  Result<MujocoRenderer> theirs = MujocoRenderer::open(simulation->model(), view);
  if (!theirs) return theirs.error();
  ImageSpec spec;
  spec.camera = view.camera;
  spec.width = view.width;
  spec.height = view.height;
  spec.outputs = FIRE3DV_IMAGE_COLOR_SRGB8 | FIRE3DV_IMAGE_DEPTH_F32 | FIRE3DV_IMAGE_INSTANCE_U32;
  Result<RequestedImages> ours = RequestedImages::open(*simulation, options.uri, spec, options.timeout_s);
  if (!ours) return ours.error();
  return options.speed ? speed(options, *simulation, *ours, *theirs)
                       : agree(options, *simulation, *ours, *theirs);
}

}  // namespace
}  // namespace fire3dv::mujoco

int main(int argc, char** argv) {
  using namespace fire3dv::mujoco;
  int exit_code = 0;
  const auto options = parse_compare_options(argc, argv, &exit_code);
  if (!options) return exit_code;
  try {
    const fire3dv::Result<EglContext> context = EglContext::open();
    if (!context) {
      log_line(context.error().message);
      return kNoOpenGl;
    }
    log_line("MuJoCo draws on " + context->renderer());
    const fire3dv::Result<void> done = run(*options);
    if (done) return 0;
    log_line(done.error().message);
  } catch (const std::exception& fault) {
    log_line(fault.what());
  }
  return kFailed;
}
