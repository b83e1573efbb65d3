#include "renderer/app/options/path_options.h"

#include <CLI/CLI.hpp>

#include "base/command_line.h"
#include "renderer/app/options/drawing_options.h"

namespace fire3dv::app {

void add_path_options(CLI::App& app, Options& options) {
  add_draw_settings(app, settings::kByCommandLine, settings::SettingGroup::paths, kDrawingGroup,
                    options.draw);
  OptionGroup group(app, kDrawingGroup);
  group.add("--checkpoint", options.checkpoint_interval_s, "S", "path: seconds between checkpoints; 0: none")
      ->check(in_range(0.0, 1e6));
}

namespace {

// Name of an option that needs path tracing, if one was given.
std::optional<std::string> option_of_paths(const CLI::App& app) {
  for (const settings::DrawSetting& setting : settings::draw_setting_table()) {
    if (setting.needs_paths && app.count("--" + setting.name) > 0) return "--" + setting.name;
  }
  return app.count("--checkpoint") > 0 ? std::optional<std::string>("--checkpoint") : std::nullopt;
}

}  // namespace

std::optional<std::string> check_path_options(const CLI::App& app, bool offline, const Options& options) {
  const settings::DrawSettings& draw = options.draw;
  // A preset may have set the other one.
  if ((draw.post.lens.f_number > 0) != (draw.post.lens.focus_distance_m > 0))
    return "--f-number and --focus-distance belong together: set both";
  if (!draw.path) {
    if (const std::optional<std::string> option = option_of_paths(app))
      return *option + " needs --render path";
    if (!draw.post.lens.is_pinhole() && draw.raster == settings::RasterPath::forward)
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
  if (options.debug_view != settings::DebugView::none) return "--render path and --view exclude each other";
  if (draw.shadows != settings::ShadowSettings())
    return "--render path traces all shadows: leave --shadows and --shadow-rays out";
  if (draw.ray_effects.on.any()) return "--render path traces all light: leave --ray-effects out";
  if (!offline && !in_window && !options.on_request && !is_served && options.frames == 0 &&
      options.out.empty() && !options.list_devices && options.recording.replay.empty())
    return "--render path would draw the same image again and again: add --frames 1";
  return std::nullopt;
}

}  // namespace fire3dv::app
