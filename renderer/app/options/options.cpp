#include "renderer/app/options/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/command_line.h"
#include "renderer/app/options/config_options.h"
#include "renderer/app/options/drawing_options.h"
#include "renderer/app/options/option_values.h"
#include "renderer/app/options/path_options.h"
#include "renderer/app/options/window_options.h"
#include "renderer/state/draw_time/draw_time_policy.h"
#include "renderer/state/motion/animation_clock.h"

namespace fire3dv::app {
namespace {

constexpr uint64_t kMaxFrames = 1'000'000'000'000;

gpu::AsyncCompute async_compute_named(const std::string& name) {
  if (name == "on") return gpu::AsyncCompute::on;
  if (name == "off") return gpu::AsyncCompute::off;
  return gpu::AsyncCompute::automatic;
}

// Values that parse_options() converts after the whole command line is known.
struct Texts {
  std::vector<std::string> peer_limits, allowed_hosts, allowed_origins;
  std::string play = "auto", mark_stale = "auto", watch = "auto", markers = "on";
  std::string size = "1280x720";
  std::string drake, stream_timeout, outputs, async_compute = "auto";
  std::string ground = "auto", debug_view = "none";
  WindowTexts window;
  std::string config;  // file of options
  double delay_ms = 0;
};

// Options whose presence matters beside their value.
struct Given {
  const CLI::Option *models, *name_space, *package_path, *xacro_argument, *up, *unit, *delay, *camera,
      *outputs, *animate, *wait_for_stream;
  std::vector<const CLI::Option*> of_descriptions;  // options of the conversion of meshes and descriptions
};

void add_input_options(CLI::App& app, Options& options, Texts& texts, Given& given) {
  OptionGroup group(app, "Input");
  app.add_option("scene", options.scene,
                 "scene: glTF, URDF, xacro, SDF, MJCF, AMBF, OBJ, STL, PLY, DAE or 3MF");
  given.models =
      group.add("--models", options.convert.models, "0,1,...|all", "AMBF: models of the launch file");
  given.name_space = group.add("--ns", options.convert.name_space, "NAME", "AMBF: namespace of the names");
  given.package_path = group
                           .add_repeatable("--package-path", options.convert.package_folders, "DIR",
                                           "folder of package://, model:// and MJCF files; repeatable")
                           ->check(CLI::ExistingDirectory.description(""));
  given.xacro_argument = group.add_repeatable("--xacro-arg", options.convert.xacro_arguments, "NAME=VALUE",
                                              "xacro: value of an argument; repeatable");
  given.up = group.add_choice("--up", options.convert.up, "y|z",
                              "OBJ, STL, PLY: up axis (default: y for OBJ, else z)");
  given.unit =
      group.add_choice("--unit", options.convert.unit, "m|cm|mm|in", "OBJ, STL, PLY: unit (default: m)");
  given.of_descriptions = {
      group.add_choice("--dae-up", options.convert.dae_up, "auto|apply|ignore",
                       "URDF, SDF: up_axis of DAE meshes; auto: ignored, as by RViz"),
      group.add_choice("--gltf-up", options.convert.gltf_up, "auto|apply|ignore",
                       "glTF meshes of URDF, SDF: turn to Z up; auto: for URDF alone"),
      group
          .add("--smooth-angle", options.convert.smooth_angle, "DEG",
               "meshes without normals: angle of smooth edges; 0: flat (default: 37)")
          ->check(number_between(0, 180)),
      group.add_flag("--confined", options.convert.is_confined,
                     "description of unknown origin: its folder and --package-path alone")};
  group.add("--assets", options.assets, "DIR", "folder of glTF files that streams and overlays may add")
      ->check(CLI::ExistingDirectory.description(""));
  given.animate = group
                      .add("--animate", options.animate, "[NAME|INDEX|all]",
                           "loop an animation of the scene (default: all)")
                      ->expected(0, 1);
  group.add_choice("--watch", texts.watch, "auto|on|off", "reload the scene when its file changes");
  group.add("--overlay", options.overlay, "FILE",
            "apply the edits of a scene in this file (docs/editing.md)");
  group.add("--variant", options.variant, "NAME", "material variant of the scene (default: none)");
}

void add_stream_options(CLI::App& app, Options& options, Texts& texts, Given& given) {
  OptionGroup group(app, "Streams");
  group.add_repeatable("--listen", options.listen, "URI",
                       "shm://NAME, or tcp, tls, udp://HOST:PORT; repeatable");
  group.add("--drake", texts.drake, "HOST:PORT", "serve Drake's render client instead (man fire3dv-drake)");
  group.add_flag("--insecure", options.insecure, "allow unprotected links beyond loopback");
  group.add("--key-file", options.key_file, "FILE", "udp: pre-shared key, 64 hexadecimal digits");
  group.add("--tls-cert", options.tls_certificate, "FILE", "tls: certificate of this renderer (PEM)");
  group.add("--tls-key", options.tls_key, "FILE", "tls: private key of that certificate (PEM)");
  group.add("--tls-client-ca", options.tls_client_ca, "FILE", "tls: require client certificates of this CA");
  group.add("--serve", options.serve, "HOST:PORT", "live view in browsers (see docs/browser.md)");
  group.add("--serve-tokens", options.serve_tokens, "FILE", "file that keeps the links of --serve valid");
  group.add_repeatable("--allow-origin", texts.allowed_origins, "URL",
                       "pages of a proxy that may use --serve, such as https://sim.example");
  group.add_repeatable("--allow-host", texts.allowed_hosts, "NAME",
                       "host name at which --serve and --metrics answer, too");
  group.add_repeatable("--peer-limit", texts.peer_limits, "LIMIT",
                       "NAME=VALUE, limit of one peer (see SPEC 14); repeatable");
  group
      .add_choice("--play", texts.play, "auto|latest|interpolate", "newest frame, or a little late and even")
      ->type_name("latest|interpolate");
  given.delay =
      group.add("--delay", texts.delay_ms, "MS", "delay of interpolated streams (default: adaptive)");
  group.add_choice("--mark-stale,--mark-held", texts.mark_stale, "auto|on|off",
                   "mark images of stalled streams");
  group.add_choice("--markers", texts.markers, "on|off|all", "show points, lines and shapes of streams");
  group.add_flag("--lockstep", options.lockstep, "draw and acknowledge every pose frame");
  given.wait_for_stream = group
                              .add("--wait-for-stream", texts.stream_timeout, "[SECONDS]",
                                   "wait for the first pose frame; fail after SECONDS")
                              ->expected(0, 1);
  group.add_flag("--exit-when-done", options.exit_when_done, "exit when the last stream has ended");
}

void add_image_options(CLI::App& app, Options& options, Texts& texts, Given& given) {
  OptionGroup group(app, "Images");
  group.add_flag("--headless", options.headless, "open no window");
  group.add_flag("--on-request", options.on_request, "draw only images that clients request (headless)");
  group.add("--size", texts.size, "WxH", "image size in pixels");
  given.camera = group.add("--camera", options.camera, "NAME|auto", "camera by node or camera name, or auto");
  group.add_flag("--frame-all", options.frame_all, "move the camera so that it shows the whole scene");
  group.add("--frames", options.frames, "N", "exit after N images")
      ->check(in_range(uint64_t{1}, kMaxFrames));  // a minus sign would wrap around
  group.add("--out", options.out, "DIR", "folder for one PNG per image");
  group.add("--instances", options.instances, "FILE", "list of instance numbers and names, kept up to date");
  given.outputs =
      group.add("--outputs", texts.outputs, "LIST", "images to write (default: color; see manual)");
}

void add_performance_options(CLI::App& app, Options& options, Texts& texts) {
  OptionGroup group(app, "Performance");
  const CLI::Option* const device = group.add("--device", options.device, "DEVICE",
                                              "Vulkan device: index, name, cuda:N, uuid:HEX, pci:ADDRESS");
  group.add("--devices", options.devices, "LIST|all", "spread requested images over several devices")
      ->excludes(const_cast<CLI::Option*>(device));
  group.add_flag("--require-gpu", options.require_gpu, "exit with status 3 rather than draw on the CPU");
  add_draw_settings(app, settings::kByCommandLine, settings::SettingGroup::raster, "Performance",
                    options.draw);
  group.add_choice("--async-compute", texts.async_compute, "auto|on|off",
                   "build acceleration structures on an async queue");
  group.add("--cache", options.cache, "WHERE", "start-up cache: auto, beside, off or a folder");
}

void add_diagnostics_options(CLI::App& app, Options& options, Texts& texts) {
  OptionGroup group(app, "Diagnostics");
  group.add("--metrics", options.metrics, "HOST:PORT", "serve /metrics over HTTP (Prometheus)");
  group.add("--stats", options.stats, "FILE", "CSV file of times per image");
  group.add("--view", texts.debug_view, "NAME", "debug view instead of light (see docs/views.md)")
      ->transform([](const std::string& name) {  // its name in an earlier version
        return name == "shadow-doubt" ? std::string("unresolved-shadows") : name;
      })
      ->check(one_of(settings::kDebugViewNames));
  group.add_flag("--validation,!--no-validation", options.validation,
                 "Vulkan validation; a finding is an error (off: --no-...)");
  group.add_flag("--list-devices", options.list_devices, "list the Vulkan devices and exit");
}

void list_given(const CLI::App& app, GivenOptions& given) {
  const auto add_names = [](const CLI::Option& option, std::vector<std::string>& names) {
    names.insert(names.end(), option.get_lnames().begin(), option.get_lnames().end());
  };
  for (const CLI::Option* option : app.get_options()) {
    if (option->count() == 0) continue;
    add_names(*option, given.present);
    for (const CLI::Option* other : option->get_excludes()) add_names(*other, given.excluded);
  }
}

// given_options: null, or set to what the words hold.
std::variant<Options, UsageError> parse_words(const std::vector<std::string>& words, bool needs_scene,
                                              OptionChecks checks, GivenOptions* given_options) {
  Options options;
#ifdef FIRE3DV_VALIDATION_DEFAULT
  options.validation = true;
#endif
  CLI::App app{"Renders a glTF scene whose nodes move as simulators publish poses."};
  app.name("fire3dv");
  set_help(app, "[SCENE] [OPTIONS]");
  app.footer(
      "Examples:\n"
      "  fire3dv arm.glb                                    view a file; F1 lists keys and mouse\n"
      "  fire3dv arm.urdf --listen shm://robot              show the poses of a simulator\n"
      "  fire3dv arm.glb --headless --frames 1 --out images write an image without a window\n\n"
      "Details: man fire3dv, or docs/man/fire3dv.1.md. Offline rendering: fire3dv render --help.");
  set_program_flags(app);
  Texts texts;
  Given given{};
  add_input_options(app, options, texts, given);
  add_stream_options(app, options, texts, given);
  add_recording_options(app, options.recording);
  add_image_options(app, options, texts, given);
  add_window_options(app, options, texts.window);
  add_drawing_options(app, settings::kByCommandLine, options);
  add_path_options(app, options);
  OptionGroup(app, kDrawingGroup)
      .add("--ground", texts.ground, "auto|off|Y", "shadows below the scene, or at a height");
  add_performance_options(app, options, texts);
  add_diagnostics_options(app, options, texts);
  OptionGroup(app, "Input")
      .add("--config", texts.config, "FILE|none", "file of options (default: ~/.config/fire3dv/config)");

  try {
    std::vector<std::string> backwards(words.rbegin(), words.rend());  // as CLI11 takes them
    app.parse(std::move(backwards));
  } catch (const CLI::ParseError& error) {
    const bool asked_for = error.get_exit_code() == 0;  // --help, --version
    if (asked_for) return UsageError{app.exit(error), ""};
    return UsageError{kUsageExitCode, usage_text(app, error)};
  }
  if (given_options) {
    list_given(app, *given_options);
    given_options->config = texts.config;
  }
  if (checks == OptionChecks::words) return options;
  const auto usage_error = [](const std::string& text) { return UsageError{kUsageExitCode, text}; };
  if (!texts.drake.empty()) return usage_error("--drake is an option of fire3dv alone");
  if (!parse_image_size(texts.size, options.width, options.height)) {
    return usage_error("--size " + texts.size + ": must be WxH with sides of 1 to " +
                       std::to_string(kMaxImageSide) + ", such as 1280x720");
  }
  if (given.animate->count() > 0 &&
      options.scene.empty()) {  // "--animate SCENE": the scene is no animation's name
    options.scene = std::exchange(options.animate, "all");
  }
  if (given.animate->count() > 0 && options.animate.empty()) options.animate = "all";
  options.wait_for_stream = given.wait_for_stream->count() > 0;
  if (!texts.stream_timeout.empty()) {
    if (const std::string wrong = settings::positive_number(texts.stream_timeout); wrong.empty()) {
      options.stream_timeout = std::chrono::duration<double>(std::stod(texts.stream_timeout));
    } else if (options.scene.empty()) {  // "--wait-for-stream SCENE": the scene is not a number
      options.scene = texts.stream_timeout;
    } else {
      return usage_error("--wait-for-stream: " + wrong);
    }
  }
  const bool replays = !options.recording.replay.empty();
  if (options.scene.empty() && needs_scene && !replays && !options.list_devices)
    return usage_error("name a scene: fire3dv SCENE.glb");
  for (const std::string& text : texts.peer_limits) {
    if (constexpr std::string_view kDrawTime = "draw-time="; text.starts_with(kDrawTime)) {
      const Result<double> factor =
          state::parse_draw_time_factor(std::string_view(text).substr(kDrawTime.size()));
      if (!factor) return usage_error("--peer-limit: " + factor.error().message);
      options.draw_time_factor = *factor;
      continue;
    }
    if (Result<void> set = set_limit(text, options.peer_limits); !set)
      return usage_error("--peer-limit: " + set.error().message);
  }
  for (const CLI::Option* option :
       {given.models, given.name_space, given.package_path, given.xacro_argument}) {
    if (option->count() > 0 && !needs_conversion(options.scene))
      return usage_error(option->get_name() + " needs a scene that is a description: .yaml, .urdf or .xml");
  }
  for (const CLI::Option* option : {given.up, given.unit}) {
    if (option->count() > 0 && !needs_conversion(options.scene))
      return usage_error(option->get_name() + " needs a scene that is a mesh file: .obj, .stl or .ply");
  }
  for (const CLI::Option* option : given.of_descriptions) {
    if (option->count() > 0 && !needs_conversion(options.scene))
      return usage_error(option->get_name() + " needs a scene that is a description or a mesh file");
  }
  if (given.outputs->count() > 0) {
    if (options.out.empty()) return usage_error("--outputs needs a folder for them: --out DIR");
    Result<wire::ImageOutputs> parsed = wire::parse_image_outputs(texts.outputs);
    if (!parsed) return usage_error("--outputs: " + parsed.error().message);
    options.outputs = *parsed;
  }
  if (options.cache.empty()) return usage_error("--cache: name a folder, or auto, beside or off");
  if (options.recording.step) options.lockstep = true;
  // Files and recordings of a run show one scene.
  const bool writes_files =
      !options.out.empty() || !options.stats.empty() || !options.recording.record.empty();
  options.watch = texts.watch == "on" || (texts.watch == "auto" && !writes_files && !options.lockstep);
  const bool receives = !options.listen.empty() || replays;
  if (options.lockstep && !receives) return usage_error("--lockstep needs a --listen URI or a --replay file");
  if (options.exit_when_done && !receives)
    return usage_error("--exit-when-done needs a --listen URI or a --replay file");
  if (options.wait_for_stream && (!receives || options.on_request))
    return usage_error(
        "--wait-for-stream needs a --listen URI or a --replay file, and excludes --on-request");
  if (!options.recording.record.empty() && !receives)
    return usage_error("--record needs a --listen URI or a --replay file");
  if (const auto wrong = check_recording_options(options.recording)) return usage_error(*wrong);
  if (!options.devices.empty() && needs_scene && options.listen.empty())
    return usage_error("--devices spreads requested images: add --listen URI");
  if (options.on_request && (!options.headless || options.listen.empty() || !options.out.empty()))
    return usage_error("--on-request needs --headless and a --listen URI, and excludes --out");
  if (options.on_request && options.frames != 0)
    return usage_error(
        "--frames counts images that are drawn unasked, and --on-request draws none: leave one out");
  const bool has_purpose = receives || !options.out.empty() || options.frames != 0 ||
                           !options.stats.empty() || !options.metrics.empty() || !options.serve.empty() ||
                           options.list_devices;
  if (options.headless && needs_scene && !has_purpose)
    return usage_error(
        "--headless without --out, --listen, --replay, --serve or --frames draws images for nobody: add "
        "--out DIR to write them, or --listen URI to draw for simulators");
  if (!options.serve_tokens.empty() && options.serve.empty())
    return usage_error("--serve-tokens is for the links of --serve HOST:PORT");
  if (!(texts.allowed_hosts.empty() && texts.allowed_origins.empty()) && options.serve.empty() &&
      options.metrics.empty())
    return usage_error("--allow-host and --allow-origin are for --serve HOST:PORT and --metrics HOST:PORT");
  Result<transport::http::AllowedSites> sites =
      transport::http::parse_allowed_sites(texts.allowed_hosts, texts.allowed_origins);
  if (!sites) return usage_error(sites.error().message);
  options.sites = std::move(*sites);
  if (const auto wrong = take_window_options(texts.window, options)) return usage_error(*wrong);
  if ((given.camera->count() > 0) + texts.window.chooses_cameras() > 1)
    return usage_error("--camera, --window and --stereo exclude one another");
  if (texts.play == "latest") options.play.mode = PlayOptions::Mode::latest;
  if (texts.play == "interpolate") options.play.mode = PlayOptions::Mode::interpolate;
  options.markers = texts.markers != "off";
  options.markers_in_data_sets = texts.markers == "all";
  if (options.markers_in_data_sets && options.outputs.has(wire::kColorLinearF16))
    return usage_error("--outputs: linear shows no markers; leave it or --markers all out");
  if (texts.mark_stale == "on") options.play.mark_held = StaleOverlay::on;
  if (texts.mark_stale == "off") options.play.mark_held = StaleOverlay::off;
  if (given.delay->count() > 0) {
    if (!(texts.delay_ms >= 0 && texts.delay_ms <= 10'000))
      return usage_error("--delay must be a number from 0 to 10000");
    options.play.delay_ns = static_cast<int64_t>(texts.delay_ms * 1e6);
  }
  if (options.lockstep && texts.play == "interpolate")
    return usage_error("--play interpolate and --lockstep (or --step) exclude each other");
  options.async_compute = async_compute_named(texts.async_compute);
  if (texts.ground == "off") options.ground = GroundMode::off;
  if (texts.ground != "auto" && texts.ground != "off") {
    if (const std::string wrong = settings::finite_number(texts.ground); !wrong.empty())
      return usage_error("--ground: " + wrong + ", auto or off");
    options.ground = GroundMode::height;
    options.ground_height_m = std::stof(texts.ground);
  }
  options.debug_view = settings::debug_view_named(texts.debug_view);
  const bool shows_light = options.debug_view == settings::DebugView::none;
  if (!shows_light && (!options.outputs.has(wire::kColorSrgb8) || options.outputs.has(wire::kColorLinearF16)))
    return usage_error(
        "--view shows something else than light: --outputs needs color and not linear beside it");
  if (!shows_light && options.on_request)
    return usage_error("--view is for images that are drawn unasked, and --on-request draws none");
  if (const auto wrong = check_path_options(app, !needs_scene, options)) return usage_error(*wrong);
  return options;
}

// True for a run that would write the same image without end.
bool writes_equal_images(const Options& options) {
  const bool is_live = !options.listen.empty() || !options.recording.replay.empty() ||
                       !options.serve.empty() || !options.metrics.empty() || options.watch;
  return options.headless && !options.out.empty() && options.frames == 0 && !options.list_devices &&
         !is_live && options.animate.empty() && options.stats.empty();
}

}  // namespace

bool lights_by_choice(const Options& options) {
  return !options.environment.empty() || options.draw.lamps.count > 0;
}

ViewDefaults view_defaults(const Options& options) {
  return {options.frame_all, options.ground, options.ground_height_m, options.draw.background};
}

std::variant<Options, int> parse_options(int argc, char** argv, bool needs_scene) {
  const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  const auto parse = [&](const std::vector<std::string>& some, OptionChecks checks, GivenOptions* given) {
    return parse_words(some, needs_scene, checks, given);
  };
  std::vector<std::string> notes;
  std::variant<Options, UsageError> parsed =
      needs_scene ? parse_with_config(
                        parse, words, [](const char* name) { return std::getenv(name); }, notes)
                  : parse(words, OptionChecks::all, nullptr);
  for (const std::string& note : notes) std::cerr << "fire3dv: info: " << note << "\n";
  if (auto* options = std::get_if<Options>(&parsed)) {
    if (needs_scene && writes_equal_images(*options)) {
      options->frames = 1;
      std::cerr << "fire3dv: info: one image is written, since nothing moves; --frames N writes more\n";
    }
    return std::move(*options);
  }
  const UsageError& error = std::get<UsageError>(parsed);
  if (!error.text.empty()) std::cerr << "fire3dv: error: " << error.text << " (see fire3dv --help)\n";
  return error.exit_code;
}

}  // namespace fire3dv::app
