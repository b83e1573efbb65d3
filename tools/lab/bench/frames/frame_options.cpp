#include "tools/lab/bench/frames/frame_options.h"

#include <charconv>

#include "protocol/base/command_line.h"
#include "renderer/app/options/image_size.h"
#include "renderer/passes/resources/draw_names.h"
#include "tools/lab/options.h"

namespace fire3dv::bench {

using lab::add_value;
using lab::in_range;

namespace {

constexpr uint64_t kMaxTriangles = 200'000'000;

}  // namespace

void add_draw_options(CLI::App& app, DrawOptions& options) {
  constexpr const char* kGroup = "Drawing";
  const auto add = [&](const char* name, std::string& value, const char* type, const char* text) {
    return add_value(app, name, value, type, text)->group(kGroup);
  };
  add("--resolution", options.resolution, "WxH", "image size in pixels");
  app.add_option("--device", options.device, "Vulkan device")->type_name("INDEX|NAME")->group(kGroup);
  add("--async-compute", options.async_compute, "auto|on|off",
      "build acceleration structures on an async queue")
      ->check(one_of({"auto", "on", "off"}));
  app.add_flag("--validation,!--no-validation", options.validation,
               "Vulkan validation; a finding is an error")
      ->group(kGroup);
  add_value(app, "--samples", options.samples, "N", "samples per pixel at most, 1 to 64")
      ->group(kGroup)
      ->check(in_range(1, 64));
  add("--raster", options.raster, "NAME", "raster path: auto, forward or visibility")
      ->check(CLI::IsMember(passes::kRasterPathNames).description(""));
  add("--cull", options.cull, "NAME", "cluster culling: on, off, view or hidden")
      ->check(CLI::IsMember(passes::kCullNames).description(""));
  add("--lod", options.levels_of_detail, "NAME", "level of detail: auto, on, everywhere or off")
      ->check(CLI::IsMember(passes::kLevelsOfDetailNames).description(""));
  add("--shadows", options.shadows, "NAME", "by auto, ray, ray-query, ray-pipeline, map or off")
      ->check(CLI::IsMember(passes::kShadowNames).description(""));
  add("--shadow-rays", options.shadow_rays, "hybrid|all", "rays for uncertain pixels, or for all lit ones")
      ->check(one_of({"hybrid", "all"}));
  add("--fxaa", options.fxaa, "on|off", "post-process antialiasing")->check(one_of({"on", "off"}));
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

passes::DrawSettings draw_settings(const DrawOptions& options) {
  passes::DrawSettings settings;
  settings.samples = options.samples;
  settings.raster = passes::raster_path_named(options.raster);
  settings.cull = passes::cull_named(options.cull);
  settings.levels_of_detail = passes::levels_of_detail_named(options.levels_of_detail);
  settings.shadows = passes::shadows_named(options.shadows);
  settings.shadows.hybrid = options.shadow_rays == "hybrid";
  settings.post.fxaa = options.fxaa == "on";
  return settings;
}

void add_frame_options(CLI::App& app, FrameOptions& options) {
  add_draw_options(app, options.draw);
  constexpr const char* kScene = "Scenes";
  add_value(app, "--sizes", options.sizes, "LIST", "triangles of the scenes")->group(kScene);
  add_value(app, "--bodies", options.bodies, "N", "moving bodies; 0: more in larger scenes")
      ->group(kScene)
      ->check(in_range(0, 100'000));
  add_value(app, "--lights", options.lights, "N", "lights with shadows")
      ->group(kScene)
      ->check(in_range(0, 16));
  add_value(app, "--texture-size", options.texture_side, "N", "side of the textures in pixels; 0: none")
      ->group(kScene)
      ->check(in_range(0, 4096));
  constexpr const char* kRun = "Measurement";
  add_value(app, "--frames", options.frames, "N", "timed frames per row")
      ->group(kRun)
      ->check(in_range(1, 100'000));
  add_value(app, "--warm-up", options.warm_up, "N", "untimed frames before them")
      ->group(kRun)
      ->check(in_range(1, 100'000));
  add_value(app, "--conditions", options.conditions, "NAME",
            "product: --cull, --lod; paper: neither; all: both")
      ->group(kRun)
      ->check(one_of({"all", "product", "paper"}));
  app.add_flag("--gui", options.gui, "draw the window's panels over the images")->group(kRun);
  add_value(app, "--gui-scale", options.gui_scale, "X", "scale of the panels")
      ->group(kRun)
      ->check(number_between(0.5, 4));
  constexpr const char* kOutput = "Output";
  add_value(app, "--out", options.out, "DIR", "folder of table, CSV file and plot")->group(kOutput);
  add_value(app, "--name", options.name, "NAME", "their file name without ending")->group(kOutput);
  app.add_option("--image", options.images, "folder for a PNG of each scene")
      ->type_name("DIR")
      ->group(kOutput);
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

}  // namespace fire3dv::bench
