// Comparison of MuJoCo's own renderer with FIRE-3DV's images: fire3dv-mujoco-compare MODEL.xml --to URI.
#include <cstdio>
#include <exception>

#include "adapters/mujoco/compare/agreement.h"
#include "adapters/mujoco/compare/image_client.h"
#include "adapters/mujoco/compare/mujoco_renderer.h"
#include "adapters/mujoco/compare/options.h"
#include "adapters/mujoco/compare/speed.h"
#include "renderer/sinks/png.h"

namespace fire3dv::mujoco {
namespace {

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
  return simulation.place();
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
