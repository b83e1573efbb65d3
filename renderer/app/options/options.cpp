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
  std::vector<std::string> peer_limits;
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
};

void add_input_options(CLI::App& app, Options& options, Texts& texts, Given& given) {
  constexpr const char* kGroup = "Input";
  app.add_option("scene", options.scene,
                 "scene: glTF, URDF, xacro, SDF, MJCF, AMBF, OBJ, STL, PLY, DAE or 3MF");
  given.models = app.add_option("--models", options.convert.models, "AMBF: models of the launch file")
                     ->type_name("0,1,...|all")
                     ->group(kGroup);
  given.name_space = app.add_option("--ns", options.convert.name_space, "AMBF: namespace of the names")
                         ->type_name("NAME")
                         ->group(kGroup);
  given.package_path = app.add_option("--package-path", options.convert.package_folders,
                                      "folder of package://, model:// and MJCF files; repeatable")
                           ->allow_extra_args(false)
                           ->check(CLI::ExistingDirectory.description(""))
                           ->type_name("DIR")
                           ->group(kGroup);
  given.xacro_argument = app.add_option("--xacro-arg", options.convert.xacro_arguments,
                                        "xacro: value of an argument; repeatable")
                             ->allow_extra_args(false)
                             ->type_name("NAME=VALUE")
                             ->group(kGroup);
  given.up = app.add_option("--up", options.convert.up, "OBJ, STL, PLY: up axis (default: y for OBJ, else z)")
                 ->check(one_of({"y", "z"}))
                 ->type_name("y|z")
                 ->group(kGroup);
  given.unit = app.add_option("--unit", options.convert.unit, "OBJ, STL, PLY: unit (default: m)")
                   ->check(one_of({"m", "cm", "mm", "in"}))
                   ->type_name("m|cm|mm|in")
                   ->group(kGroup);
  app.add_option("--assets", options.assets, "folder of glTF files that streams and overlays may add")
      ->check(CLI::ExistingDirectory.description(""))
      ->type_name("DIR")
      ->group(kGroup);
  given.animate =
      app.add_option("--animate", options.animate, "loop an animation of the scene (default: all)")
          ->expected(0, 1)
          ->type_name("[NAME|INDEX|all]")
          ->group(kGroup);
  app.add_option("--watch", texts.watch, "reload the scene when its file changes")
      ->check(one_of({"auto", "on", "off"}))
      ->type_name("auto|on|off")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--overlay", options.overlay, "apply the edits of a scene in this file (docs/editing.md)")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--variant", options.variant, "material variant of the scene (default: none)")
      ->type_name("NAME")
      ->group(kGroup);
}

void add_stream_options(CLI::App& app, Options& options, Texts& texts, Given& given) {
  constexpr const char* kGroup = "Streams";
  app.add_option("--listen", options.listen, "shm://NAME, or tcp, tls, udp://HOST:PORT; repeatable")
      ->allow_extra_args(false)
      ->type_name("URI")
      ->group(kGroup);
  app.add_option("--drake", texts.drake, "serve Drake's render client instead (man fire3dv-drake)")
      ->type_name("HOST:PORT")
      ->group(kGroup);
  app.add_flag("--insecure", options.insecure, "allow unprotected links beyond loopback")->group(kGroup);
  app.add_option("--key-file", options.key_file, "udp: pre-shared key, 64 hexadecimal digits")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--tls-cert", options.tls_certificate, "tls: certificate of this renderer (PEM)")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--tls-key", options.tls_key, "tls: private key of that certificate (PEM)")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--tls-client-ca", options.tls_client_ca, "tls: require client certificates of this CA")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--serve", options.serve, "live view in browsers (see docs/browser.md)")
      ->type_name("HOST:PORT")
      ->group(kGroup);
  app.add_option("--serve-tokens", options.serve_tokens, "file that keeps the links of --serve valid")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--peer-limit", texts.peer_limits, "NAME=VALUE, limit of one peer (see SPEC 14); repeatable")
      ->allow_extra_args(false)
      ->type_name("LIMIT")
      ->group(kGroup);
  app.add_option("--play", texts.play, "newest frame, or a little late and even")
      ->check(one_of({"auto", "latest", "interpolate"}))
      ->type_name("latest|interpolate")
      ->capture_default_str()
      ->group(kGroup);
  given.delay = app.add_option("--delay", texts.delay_ms, "delay of interpolated streams (default: adaptive)")
                    ->type_name("MS")
                    ->group(kGroup);
  app.add_option("--mark-stale,--mark-held", texts.mark_stale, "mark images of stalled streams")
      ->check(one_of({"auto", "on", "off"}))
      ->type_name("auto|on|off")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--markers", texts.markers, "show points, lines and shapes of streams")
      ->check(one_of({"on", "off", "all"}))
      ->type_name("on|off|all")
      ->capture_default_str()
      ->group(kGroup);
  app.add_flag("--lockstep", options.lockstep, "draw and acknowledge every pose frame")->group(kGroup);
  given.wait_for_stream = app.add_option("--wait-for-stream", texts.stream_timeout,
                                         "wait for the first pose frame; fail after SECONDS")
                              ->expected(0, 1)
                              ->type_name("[SECONDS]")
                              ->group(kGroup);
  app.add_flag("--exit-when-done", options.exit_when_done, "exit when the last stream has ended")
      ->group(kGroup);
}

void add_image_options(CLI::App& app, Options& options, Texts& texts, Given& given) {
  constexpr const char* kGroup = "Images";
  app.add_flag("--headless", options.headless, "open no window")->group(kGroup);
  app.add_flag("--on-request", options.on_request, "draw only images that clients request (headless)")
      ->group(kGroup);
  app.add_option("--size", texts.size, "image size in pixels")
      ->type_name("WxH")
      ->capture_default_str()
      ->group(kGroup);
  given.camera = app.add_option("--camera", options.camera, "camera by node or camera name, or auto")
                     ->type_name("NAME|auto")
                     ->group(kGroup);
  app.add_flag("--frame-all", options.frame_all, "move the camera so that it shows the whole scene")
      ->group(kGroup);
  app.add_option("--frames", options.frames, "exit after N images")
      ->check(CLI::Range(uint64_t{0}, kMaxFrames).description(""))  // a minus sign would wrap around
      ->type_name("N")
      ->group(kGroup);
  app.add_option("--out", options.out, "folder for one PNG per image")->type_name("DIR")->group(kGroup);
  given.outputs = app.add_option("--outputs", texts.outputs, "images to write (default: color; see manual)")
                      ->type_name("LIST")
                      ->group(kGroup);
}

void add_performance_options(CLI::App& app, Options& options, Texts& texts) {
  constexpr const char* kGroup = "Performance";
  const CLI::Option* const device =
      app.add_option("--device", options.device, "Vulkan device")->type_name("INDEX|NAME")->group(kGroup);
  app.add_option("--devices", options.devices, "spread requested images over several devices")
      ->type_name("LIST|all")
      ->excludes(const_cast<CLI::Option*>(device))
      ->group(kGroup);
  add_draw_settings(app, passes::kByCommandLine, passes::SettingGroup::raster, kGroup, options.draw);
  app.add_option("--async-compute", texts.async_compute, "build acceleration structures on an async queue")
      ->check(one_of({"auto", "on", "off"}))
      ->type_name("auto|on|off")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--cache", options.cache, "start-up cache: auto, beside, off or a folder")
      ->type_name("WHERE")
      ->capture_default_str()
      ->group(kGroup);
}

void add_diagnostics_options(CLI::App& app, Options& options, Texts& texts) {
  constexpr const char* kGroup = "Diagnostics";
  app.add_option("--metrics", options.metrics, "serve /metrics over HTTP (Prometheus)")
      ->type_name("HOST:PORT")
      ->group(kGroup);
  app.add_option("--stats", options.stats, "CSV file of times per image")->type_name("FILE")->group(kGroup);
  app.add_option("--view", texts.debug_view, "debug view instead of light (see docs/views.md)")
      ->transform([](const std::string& name) {  // its name in an earlier version
        return name == "shadow-doubt" ? std::string("unresolved-shadows") : name;
      })
      ->check(one_of(passes::kDebugViewNames))
      ->type_name("NAME")
      ->capture_default_str()
      ->group(kGroup);
  app.add_flag("--validation,!--no-validation", options.validation,
               "Vulkan validation; a finding is an error (off: --no-...)")
      ->group(kGroup);
  app.add_flag("--list-devices", options.list_devices, "list the Vulkan devices and exit")->group(kGroup);
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
  app.formatter(std::make_shared<HelpFormatter>("[SCENE] [OPTIONS]"));
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
  add_drawing_options(app, passes::kByCommandLine, options);
  add_path_options(app, options);
  app.add_option("--ground", texts.ground, "shadows below the scene, or at a height")
      ->type_name("auto|off|Y")
      ->capture_default_str()
      ->group(kDrawingGroup);
  add_performance_options(app, options, texts);
  add_diagnostics_options(app, options, texts);
  app.add_option("--config", texts.config, "file of options (default: ~/.config/fire3dv/config)")
      ->type_name("FILE|none")
      ->group("Input");

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
    if (const std::string wrong = passes::positive_number(texts.stream_timeout); wrong.empty()) {
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
  if (!options.devices.empty() && options.listen.empty())
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
    if (const std::string wrong = passes::finite_number(texts.ground); !wrong.empty())
      return usage_error("--ground: " + wrong + ", auto or off");
    options.ground = GroundMode::height;
    options.ground_height_m = std::stof(texts.ground);
  }
  options.debug_view = passes::debug_view_named(texts.debug_view);
  const bool shows_light = options.debug_view == passes::DebugView::none;
  if (!shows_light && (!options.outputs.has(wire::kColorSrgb8) || options.outputs.has(wire::kColorLinearF16)))
    return usage_error(
        "--view shows something else than light: --outputs needs color and not linear beside it");
  if (!shows_light && options.on_request)
    return usage_error("--view is for images that are drawn unasked, and --on-request draws none");
  if (const auto wrong = check_path_options(app, !needs_scene, options)) return usage_error(*wrong);
  return options;
}

}  // namespace

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
  if (auto* options = std::get_if<Options>(&parsed)) return std::move(*options);
  const UsageError& error = std::get<UsageError>(parsed);
  if (!error.text.empty()) std::cerr << "fire3dv: error: " << error.text << " (see fire3dv --help)\n";
  return error.exit_code;
}

}  // namespace fire3dv::app
