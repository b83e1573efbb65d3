#include "renderer/app/options/path_options.h"

#include <CLI/CLI.hpp>

#include "base/command_line.h"
#include "renderer/app/options/drawing_options.h"
#include "renderer/app/options/option_values.h"

namespace fire3dv::app {
namespace {

constexpr uint32_t kMaxSamplesPerPixel = 1 << 20, kMaxBounces = 1024;

}  // namespace

void add_path_options(CLI::App& app, PathTexts& texts) {
  constexpr const char* kGroup = kDrawingGroup;
  app.add_option("--render", texts.render, "raster, or paths: a reference image (docs/truth.md)")
      ->check(one_of({"raster", "path"}))
      ->type_name("raster|path")
      ->capture_default_str()
      ->group(kGroup);
  texts.samples_per_pixel =
      app.add_option("--spp", texts.settings.samples_per_pixel, "path: samples per pixel")
          ->check(CLI::Range(1u, kMaxSamplesPerPixel).description(""))
          ->type_name("N")
          ->capture_default_str()
          ->group(kGroup);
  texts.bounces = app.add_option("--bounces", texts.settings.bounces, "path: bounces after the first surface")
                      ->check(CLI::Range(0u, kMaxBounces).description(""))
                      ->type_name("N")
                      ->capture_default_str()
                      ->group(kGroup);
  texts.seed = app.add_option("--seed", texts.settings.seed, "path: seed of the random numbers")
                   ->check(CLI::Range(uint64_t{0}, uint64_t{UINT32_MAX}).description(""))
                   ->type_name("N")
                   ->capture_default_str()
                   ->group(kGroup);
  texts.f_number = app.add_option("--f-number", texts.settings.lens.f_number, "aperture of the lens")
                       ->check(f_number)
                       ->type_name("N")
                       ->group(kGroup);
  texts.focus_distance =
      app.add_option("--focus-distance", texts.settings.lens.focus_distance_m, "metres to the plane in focus")
          ->check(focus_distance_m)
          ->type_name("M")
          ->group(kGroup);
  texts.checkpoint = app.add_option("--checkpoint", texts.checkpoint_interval_s,
                                    "path: seconds between checkpoints; 0: none")
                         ->check(CLI::Range(0.0, 1e6).description(""))
                         ->type_name("S")
                         ->capture_default_str()
                         ->group(kGroup);
}

std::optional<std::string> take_path_options(const PathTexts& texts, bool offline, Options& options) {
  if (texts.f_number->count() != texts.focus_distance->count())
    return "--f-number and --focus-distance belong together: set both";
  options.lens = texts.settings.lens;
  if (texts.render != "path") {
    for (const CLI::Option* option : {texts.samples_per_pixel, texts.bounces, texts.seed, texts.checkpoint}) {
      if (option->count() > 0) return option->get_name() + " needs --render path";
    }
    if (!options.lens.is_pinhole() && options.raster == passes::RasterPath::forward)
      return "--f-number needs the depths of the visibility buffer: leave --raster forward out";
    return std::nullopt;
  }
  const bool in_window = !options.headless && !offline;
  const bool is_served = !options.serve.empty();
  if (is_served && in_window)
    return "--render path refines the image of the window or those of --serve: add --headless, or leave "
           "--serve out";
  if (is_served && !options.on_request &&
      (options.frames != 0 || !options.out.empty() || !options.stats.empty() || options.lockstep))
    return "--render path with --serve draws for viewers alone: leave --frames, --out, --stats and "
           "--lockstep "
           "out";
  if (!in_window && !options.listen.empty() && !options.on_request && !is_served)
    return "--render path without a window draws live streams by their requests alone: add --on-request, or "
           "record the stream, then fire3dv render FILE.mcap --render path";
  if (!options.devices.empty()) return "--render path traces on one device: --device instead of --devices";
  if (in_window) {
    if (options.lockstep)
      return "--render path in a window refines its image, and --lockstep awaits whole ones";
    if (!options.out.empty())
      return "--render path in a window refines its image: take screenshots (key P) instead of --out, or add "
             "--headless --frames 1";
    if (options.window_cameras.size() > 1 || !options.right_camera.empty())
      return "--render path refines one view: name one --window and no --stereo";
  }
  if (options.debug_view != passes::DebugView::none) return "--render path and --view exclude each other";
  if (options.shadows != passes::ShadowSettings())
    return "--render path traces all shadows: leave --shadows and --shadow-rays out";
  if (options.ray_effects.any()) return "--render path traces all light: leave --ray-effects out";
  if (!offline && !in_window && !options.on_request && !is_served && options.frames == 0 &&
      !options.list_devices && options.recording.replay.empty())
    return "--render path would draw the same image again and again: add --frames 1";
  options.path = texts.settings;
  options.checkpoint_interval_s = texts.checkpoint_interval_s;
  return std::nullopt;
}

}  // namespace fire3dv::app
