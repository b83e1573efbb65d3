#include "programs/drake/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/command_line.h"
#include "renderer/app/options/drawing_options.h"

namespace fire3dv::drake {
namespace {

constexpr int kUsageError = 2;

// Values that parse_options() converts after the whole command line is known.
struct Texts {
  std::string depth = "32f";
  uint64_t request_mib = 0, scene_mib = 0, images_mib = 0, cache_mib = 0;
  uint32_t timeout_s = 0;
  std::vector<std::string> allowed_hosts, allowed_origins;
};

void add_server_options(CLI::App& app, Options& options, Texts& texts) {
  OptionGroup group(app, "Server");
  app.add_option("address", options.address, "address to serve, such as 127.0.0.1:8000")->required();
  group.add_flag("--insecure", options.drawing.insecure, "allow addresses beyond loopback");
  group.add_repeatable("--allow-host", texts.allowed_hosts, "NAME",
                       "answer requests to this host name, too; repeatable");
  group.add_repeatable("--allow-origin", texts.allowed_origins, "URL",
                       "answer pages of this origin, too; repeatable");
  group.add("--connections", options.http.max_connections, "N", "limit of connections, 1 to 1000")
      ->check(in_range(1, 1000));
  group.add("--timeout", texts.timeout_s, "SECONDS", "time in which a request must arrive, 1 to 3600")
      ->check(in_range(1, 3600));
  group.add("--max-request", texts.request_mib, "MIB", "limit of one request, 1 to 2047")
      ->check(in_range(1, 2047));
  group.add("--max-scene", texts.scene_mib, "MIB", "limit of one loaded scene in memory")
      ->check(in_range(1, 1 << 20));
  group.add("--max-images", texts.images_mib, "MIB", "limit of one scene's images, decoded")
      ->check(in_range(1, 1 << 20));
  group.add("--max-cache", texts.cache_mib, "MIB", "limit of all scenes that stay loaded")
      ->check(in_range(1, 1 << 20));
  group.add("--scenes", options.render.max_scenes, "N", "scenes that stay loaded, 1 to 64")
      ->check(in_range(1, 64));
}

void add_device_options(CLI::App& app, app::Options& drawing) {
  OptionGroup group(app, "Device");
  group.add("--device", drawing.device, "DEVICE",
            "Vulkan device: index, name, cuda:N, uuid:HEX, pci:ADDRESS");
  group.add_flag("--require-gpu", drawing.require_gpu, "exit with status 3 rather than draw on the CPU");
  group.add("--cache", drawing.cache, "WHERE", "start-up cache of pipelines: auto, off or a folder");
  group.add_flag("--validation,!--no-validation", drawing.validation,
                 "Vulkan validation; a finding is an error (off: --no-...)");
}

void convert(const Texts& texts, Options& options) {
  options.drawing.headless = true;
  options.render.depth_format = texts.depth == "16u" ? DepthFormat::uint16_mm : DepthFormat::float32_m;
  options.render.max_scene_bytes = texts.scene_mib << 20;
  options.render.max_image_bytes = texts.images_mib << 20;
  options.render.max_cached_bytes = texts.cache_mib << 20;
  options.http.max_body_bytes = texts.request_mib << 20;
  options.http.max_total_bytes = std::max(options.http.max_total_bytes, 2 * options.http.max_body_bytes);
  options.http.body_timeout = std::chrono::seconds(texts.timeout_s);
  options.http.header_timeout = std::min(options.http.header_timeout, options.http.body_timeout);
}

}  // namespace

std::variant<Options, int> parse_options(int argc, char** argv) {
  Options options;
#ifdef FIRE3DV_VALIDATION_DEFAULT
  options.drawing.validation = true;
#endif
  Texts texts;
  texts.request_mib = options.http.max_body_bytes >> 20;
  texts.scene_mib = options.render.max_scene_bytes >> 20;
  texts.images_mib = options.render.max_image_bytes >> 20;
  texts.cache_mib = options.render.max_cached_bytes >> 20;
  texts.timeout_s = static_cast<uint32_t>(options.http.body_timeout.count());
  CLI::App app{"Renders images for Drake's RenderEngineGltfClient, over HTTP."};
  app.name("fire3dv-drake");
  set_help(app, "HOST:PORT [OPTIONS]");
  app.footer("Details: man fire3dv-drake, or docs/man/fire3dv-drake.1.md.");
  set_program_flags(app);
  add_server_options(app, options, texts);
  OptionGroup(app, app::kDrawingGroup)
      .add_choice("--depth", texts.depth, "32f|16u", "depths as float metres, or as 16-bit millimetres");
  app::add_drawing_options(app, settings::kByDrake, options.drawing);
  add_device_options(app, options.drawing);
  const auto usage_error = [](const std::string& text) {
    std::cerr << "fire3dv-drake: error: " << text << " (see fire3dv-drake --help)\n";
    return kUsageError;
  };
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    return usage_error(usage_text(app, error));
  }
  Result<transport::http::AllowedSites> sites =
      transport::http::parse_allowed_sites(texts.allowed_hosts, texts.allowed_origins);
  if (!sites) return usage_error(sites.error().message);
  options.sites = std::move(*sites);
  convert(texts, options);
  return options;
}

}  // namespace fire3dv::drake
