#include "tools/lab/bench/frames/frame_options.h"

#include <charconv>

#include "protocol/base/command_line.h"
#include "renderer/app/options/image_size.h"
#include "renderer/passes/resources/draw_names.h"

namespace fire3dv::bench {
namespace {

constexpr uint64_t kMostTriangles = 200'000'000;

}  // namespace

void add_draw_options(CLI::App& app, DrawOptions& options) {
  app.add_option("--resolution", options.resolution, "of the images, WxH")->capture_default_str();
  app.add_option("--device", options.device, "Vulkan device by index or part of its name");
  app.add_option("--async-compute", options.async_compute,
                 "build acceleration structures on an async compute queue")
      ->check(CLI::IsMember({"auto", "on", "off"}))
      ->capture_default_str();
  app.add_flag("--validation,!--no-validation", options.validation,
               "check every Vulkan call; a finding ends the run with exit code 1");
  app.add_option("--samples", options.samples, "samples per pixel")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--raster", options.raster, "how triangles are drawn")
      ->check(CLI::IsMember(passes::kRasterPathNames))
      ->capture_default_str();
  app.add_option("--cull", options.cull,
                 "what is left out: nothing, what is out of view, or what is hidden too; on: the last in "
                 "large scenes")
      ->check(CLI::IsMember(passes::kCullNames))
      ->capture_default_str();
  app.add_option(
         "--lod", options.levels_of_detail,
         "coarser triangles where the difference is less than a pixel: in scenes where they pay, in all, "
         "in lights' maps, too, or never")
      ->check(CLI::IsMember(passes::kLevelsOfDetailNames))
      ->capture_default_str();
  app.add_option("--shadows", options.shadows, "how shadows are found")
      ->check(CLI::IsMember(passes::kShadowNames))
      ->capture_default_str();
  app.add_option("--shadow-rays", options.shadow_rays, "rays only where maps cannot tell, or all")
      ->check(CLI::IsMember({"hybrid", "all"}))
      ->capture_default_str();
  app.add_option("--fxaa", options.fxaa, "smooths edges in the finished image")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
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
  app.add_option("--sizes", options.sizes,
                 "triangles of the scenes, with commas between them, such as 223K,7M")
      ->capture_default_str();
  app.add_option("--bodies", options.bodies,
                 "moving bodies of each scene; 0: more where there are more triangles")
      ->check(CLI::Range(0, 100'000))
      ->capture_default_str();
  app.add_option("--lights", options.lights, "lights, all of which cast shadows")
      ->check(CLI::Range(0, 16))
      ->capture_default_str();
  app.add_option("--texture-size", options.texture_side, "side of the textures in pixels; 0: none")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  app.add_option("--frames", options.frames, "timed frames of each row")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  app.add_option("--warm-up", options.warm_up, "frames before them")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  app.add_option("--conditions", options.conditions,
                 "product: culling and levels of detail as --cull and --lod say; paper: neither; all: both")
      ->check(CLI::IsMember({"all", "product", "paper"}))
      ->capture_default_str();
  app.add_flag("--gui", options.gui, "draw the window's panels over the images, as they are at first");
  app.add_option("--gui-scale", options.gui_scale, "of the panels, 2 on a display of twice the density")
      ->check(number_between(0.5, 4))
      ->capture_default_str();
  app.add_option("--out", options.out, "folder for the table, the CSV file and the plot")
      ->capture_default_str();
  app.add_option("--name", options.name, "of these files")->capture_default_str();
  app.add_option("--image", options.images, "folder for a PNG of each scene at its first step");
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
  if (error != std::errc() || factor == 0 || number > kMostTriangles || number * factor > kMostTriangles ||
      number * factor < kFewest) {
    return Error{"\"" + std::string(text) + "\" is no number of triangles from 1K to 200M"};
  }
  return number * factor;
}

std::string triangles_text(uint64_t triangles) {
  if (triangles % 1'000'000 == 0) return std::to_string(triangles / 1'000'000) + "M";
  if (triangles % 1'000 == 0) return std::to_string(triangles / 1'000) + "K";
  return std::to_string(triangles);
}

}  // namespace fire3dv::bench
