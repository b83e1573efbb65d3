#include "renderer/app/options/path_options.h"

#include <CLI/CLI.hpp>

#include "protocol/base/command_line.h"
#include "renderer/app/options/drawing_options.h"
#include "renderer/app/options/option_values.h"

namespace fire3dv::app {
namespace {

constexpr uint32_t kMaxSamplesPerPixel = 1 << 20, kMaxBounces = 1024;

}  // namespace

void add_path_options(CLI::App& app, PathTexts& texts) {
  constexpr const char* kGroup = kDrawingGroup;
  app.add_option("--render", texts.render, "raster, or a path-traced reference image (headless)")
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
  texts.f_number = app.add_option("--f-number", texts.settings.lens.f_number, "path: aperture of the lens")
                       ->check(f_number)
                       ->type_name("N")
                       ->group(kGroup);
  texts.focus_distance = app.add_option("--focus-distance", texts.settings.lens.focus_distance_m,
                                        "path: metres to the plane in focus")
                             ->check(focus_distance_m)
                             ->type_name("M")
                             ->group(kGroup);
}

std::optional<std::string> take_path_options(const PathTexts& texts, bool offline, Options& options) {
  if (texts.render != "path") {
    for (const CLI::Option* option :
         {texts.samples_per_pixel, texts.bounces, texts.seed, texts.f_number, texts.focus_distance}) {
      if (option->count() > 0) return option->get_name() + " needs --render path";
    }
    return std::nullopt;
  }
  if (!options.headless && !offline)
    return "--render path takes seconds an image and opens no window: add --headless --frames 1 --out DIR";
  if (!options.listen.empty() || options.on_request || !options.serve.empty())
    return "--render path draws no live streams, no live view and no images on request: record the stream, "
           "then fire3dv "
           "render FILE.mcap --render path";
  if (options.debug_view != passes::DebugView::none) return "--render path and --view exclude each other";
  if (options.shadows != passes::ShadowSettings())
    return "--render path traces all shadows: leave --shadows and --shadow-rays out";
  if (options.ray_effects.any()) return "--render path traces all light: leave --ray-effects out";
  if (!offline && options.frames == 0 && !options.list_devices && options.recording.replay.empty())
    return "--render path would draw the same image again and again: add --frames 1";
  if (texts.f_number->count() != texts.focus_distance->count())
    return "--f-number and --focus-distance belong together: set both";
  options.path = texts.settings;
  return std::nullopt;
}

}  // namespace fire3dv::app
