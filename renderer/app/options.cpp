#include "renderer/app/options.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <iostream>
#include <optional>
#include <string_view>
#include <utility>

#include "renderer/app/animation_clock.h"
#include "renderer/app/image_size.h"
#include "renderer/app/version.h"
#include "renderer/passes/draw_names.h"

namespace fire3dv::app {
namespace {

constexpr int kUsageError = 2;
constexpr uint64_t kMostFrames = 1'000'000'000'000;

// CLI11's own check lets NaN and infinity pass.
std::string positive_number(const std::string& text) {
  float value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool good =
      error == std::errc() && end == text.data() + text.size() && std::isfinite(value) && value > 0;
  return good ? "" : text + " is not a number above 0";
}

std::string number_from_zero(const std::string& text) {
  return text == "0" ? "" : positive_number(text);
}

std::string finite_number(const std::string& text) {
  float value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool good = error == std::errc() && end == text.data() + text.size() && std::abs(value) <= 1e6f;
  return good ? "" : text + " is not a number between -1000000 and 1000000";
}

std::string anisotropy_number(const std::string& text) {
  float value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool good =
      error == std::errc() && end == text.data() + text.size() && value >= 1 && value <= 16;  // not NaN
  return good ? "" : text + " is not a number from 1 to 16";
}

// "environment", or the light of a display's colour.
bool parse_background(std::string_view text, passes::Background& background) {
  if (text == "environment") {
    background.surroundings = true;
    return true;
  }
  if (text.starts_with('#')) text.remove_prefix(1);  // shells take it for a comment, so it may be left out
  uint32_t rgb = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), rgb, 16);
  if (error != std::errc() || end != text.data() + text.size() || text.size() != 6) return false;
  for (int c = 0; c < 3; ++c) {
    const float encoded = static_cast<float>(rgb >> (16 - 8 * c) & 0xff) / 255;
    background.color[c] =
        encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
  }
  return true;
}

passes::ToneMap tone_map_named(const std::string& name) {
  if (name == "reinhard") return passes::ToneMap::reinhard;
  if (name == "aces") return passes::ToneMap::aces;
  if (name == "neutral") return passes::ToneMap::neutral;
  return passes::ToneMap::none;
}

gpu::AsyncCompute async_compute_named(const std::string& name) {
  if (name == "on") return gpu::AsyncCompute::on;
  if (name == "off") return gpu::AsyncCompute::off;
  return gpu::AsyncCompute::automatic;
}

// A sentence where it is wrong.
std::optional<std::string> take_window_options(const std::string& stereo, const std::string& present,
                                               Options& options) {
  if (present == "mailbox") options.present = sinks::Present::mailbox;
  if (present == "immediate") options.present = sinks::Present::immediate;
  constexpr size_t kMostWindows = 16;
  if (options.window_cameras.size() > kMostWindows)
    return "--window: " + std::to_string(kMostWindows) + " windows at most";
  if (!options.window_cameras.empty()) options.camera = options.window_cameras.front();
  if (stereo.empty()) return std::nullopt;
  const size_t comma = stereo.find(',');
  if (comma == 0 || comma == std::string::npos || comma + 1 == stereo.size())
    return "--stereo " + stereo + ": must be two cameras, such as left,right";
  options.camera = stereo.substr(0, comma);
  options.right_camera = stereo.substr(comma + 1);
  return std::nullopt;
}

}  // namespace

std::variant<Options, int> parse_options(int argc, char** argv, bool needs_scene) {
  Options options;
  CLI::App app{
      "FIRE-3DV: shows what simulators do. Draws a glTF scene and moves its nodes as adapters publish "
      "poses."};
  app.name("fire3dv");
  app.set_version_flag("--version", kVersion);

  app.add_option(
      "scene", options.scene,
      "glTF 2.0 scene (.glb or .gltf), or a description that fire3dv-convert makes one of: AMBF (.yaml), "
      "URDF (.urdf) or MJCF (.xml)");
  CLI::Option* const models =
      app.add_option("--models", options.convert.models,
                     "which models of an AMBF launch file, as AMBF's -l takes them, or all")
          ->type_name("0,1,...|all");
  CLI::Option* const name_space =
      app.add_option("--ns", options.convert.name_space, "AMBF's namespace, as its --ns takes it");
  CLI::Option* const package_path =
      app.add_option(
             "--package-path", options.convert.package_folders,
             "folder of packages (package:// in URDF) or of what MJCF names; may be given several times")
          ->allow_extra_args(false)
          ->check(CLI::ExistingDirectory);
  app.add_option("--listen", options.listen,
                 "where adapters publish: shm://NAME, tcp://HOST:PORT, tls://HOST:PORT or "
                 "udp://HOST:PORT; may be given several times")
      ->allow_extra_args(false);
  app.add_flag("--insecure", options.insecure,
               "let --listen and --metrics take addresses other than loopback, without protection");
  app.add_option("--key-file", options.key_file,
                 "file of the key (64 hexadecimal digits) that adapters must have to publish over udp://");
  app.add_option("--tls-cert", options.tls_certificate, "this renderer's certificate for tls://, a PEM file");
  app.add_option("--tls-key", options.tls_key, "file of that certificate's key");
  app.add_option(
      "--tls-client-ca", options.tls_client_ca,
      "file of certificates; adapters must show one that these have signed to publish over tls://");
  app.add_option(
      "--metrics", options.metrics,
      "HOST:PORT where streams, links, images and memory are told in numbers, over HTTP as /metrics "
      "(Prometheus' text format)");
  std::vector<std::string> peer_limits;
  app.add_option("--peer-limit", peer_limits,
                 "limit on what one adapter may use, NAME=VALUE (edit-bytes=64MiB, nodes=100); the names stand "
                 "in protocol/SPEC.md, section 14; may be given several times")
      ->allow_extra_args(false);
  std::string play = "auto";
  app.add_option("--play", play,
                 "latest: the newest frame at once; interpolate: a little late and evenly; auto: interpolate "
                 "what comes from "
                 "other machines")
      ->check(CLI::IsMember({"auto", "latest", "interpolate"}))
      ->capture_default_str();
  double delay_ms = 0;
  const CLI::Option* const fixed_delay =
      app.add_option("--delay", delay_ms,
                     "how late interpolated streams are shown, in milliseconds; unless given, it "
                     "follows their jitter");
  std::string mark_held = "auto";
  app.add_option("--mark-held", mark_held,
                 "mark images whose stream sends no frames, by a striped frame and a badge: auto, those of "
                 "interpolated streams; on; off")
      ->check(CLI::IsMember({"auto", "on", "off"}))
      ->capture_default_str();
  app.add_flag("--lockstep", options.lockstep,
               "draw every pose frame exactly once and tell the adapter when it is done");

  add_recording_options(app, options.recording);

  app.add_flag("--headless", options.headless, "open no window");
  app.add_flag("--on-request", options.on_request,
               "draw nothing but the images that simulators ask for; with --headless and --listen");
  std::string size = "1280x720";
  app.add_option("--size", size, "image size, WxH")->capture_default_str();
  CLI::Option* const camera = app.add_option("--camera", options.camera, "camera by node or camera name");
  CLI::Option* const windows =
      app.add_option("--window", options.window_cameras,
                     "a window with this camera; given several times, several windows")
          ->type_name("CAMERA")
          ->allow_extra_args(false);
  std::string stereo;
  app.add_option("--stereo", stereo, "two cameras side by side in one window")->type_name("LEFT,RIGHT");
  std::string gui = "on";
  app.add_option("--gui", gui, "panels over the window's image, which Tab shows and hides: on or off")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  std::string present = "vsync";
  app.add_option("--present", present,
                 "when the window shows an image: vsync, in step with the display; mailbox, the newest then; "
                 "immediate, at once, which may tear")
      ->check(CLI::IsMember({"vsync", "mailbox", "immediate"}))
      ->capture_default_str();
  CLI::Option* const screenshots =
      app.add_option("--screenshots", options.screenshots,
                     "folder of the screenshots and videos that the window's keys P and V take")
          ->capture_default_str();
  app.add_option("--assets", options.assets,
                 "folder of glTF files that streams may add to the scene by name; without it none is read")
      ->check(CLI::ExistingDirectory);
  CLI::Option* animate = app.add_option(
      "--animate", options.animate,
      "play an animation of the scene in a loop, by name or index, or all that do not contradict one another "
      "(all, the default); time is the adapter's simulated one, else the clock's, or without a window " +
          std::to_string(kHeadlessImagesPerSecond) + " images a second");
  animate->expected(0, 1)->type_name("[NAME|INDEX|all]");
  app.add_option("--frames", options.frames, "stop after this many images")
      ->check(CLI::Range(uint64_t{0}, kMostFrames).description(""));  // a minus sign would wrap around
  std::string stream_timeout;
  CLI::Option* const wait_for_stream =
      app.add_option("--wait-for-stream", stream_timeout,
                     "wait for the first pose frame of any stream before images are written and counted by "
                     "--frames; fail after SECONDS without one (default: no limit)")
          ->expected(0, 1)
          ->type_name("[SECONDS]");
  app.add_flag("--exit-when-done", options.exit_when_done, "stop when the last stream has ended");
  app.add_option("--out", options.out, "folder for one PNG per image");
  std::string outputs;
  CLI::Option* const wanted_outputs = app.add_option(
      "--outputs", outputs,
      "what is written of each image, separated by commas: color (a PNG, the default); as NumPy "
      "files linear, depth, instance, semantic, normal, motion; boxes2d and boxes3d into "
      "frames.jsonl");
  app.add_option("--stats", options.stats, "CSV file of times per image");

  app.add_option(
         "--cache", options.cache,
         "where loaded scenes, compiled pipelines and prepared surroundings are kept for the next "
         "start: auto (in the user's cache folder), beside (scenes beside their files), off, or a folder")
      ->type_name("[auto|beside|off|FOLDER]")
      ->capture_default_str();

  CLI::Option* const device =
      app.add_option("--device", options.device, "Vulkan device by index or part of its name");
  app.add_option(
         "--devices", options.devices,
         "several, separated by commas, or all: images that simulators ask for are spread over them; the "
         "first one draws all else")
      ->type_name("[LIST|all]")
      ->excludes(device);
  std::string async_compute = "auto";
  app.add_option(
         "--async-compute", async_compute,
         "build what rays meet on a queue of its own while the main one draws: auto, where the device "
         "has one; on, where it has none too, in submissions of their own; off: one submission an "
         "image. The images are the same")
      ->check(CLI::IsMember({"auto", "on", "off"}))
      ->capture_default_str();
  app.add_flag("--list-devices", options.list_devices, "list the Vulkan devices and stop");
#ifdef FIRE3DV_VALIDATION_DEFAULT
  options.validation = true;
#endif
  app.add_flag("--validation,!--no-validation", options.validation,
               "check every Vulkan call; a finding ends the run with exit code 1");

  app.add_option(
      "--environment", options.environment,
      "surroundings that light the scene: an equirectangular Radiance picture (.hdr); without, a studio");
  app.add_option("--environment-rotation", options.environment_rotation_deg,
                 "degrees that the surroundings are turned by, counter-clockwise seen from above")
      ->check(finite_number)
      ->capture_default_str();
  app.add_option("--environment-intensity", options.environment_intensity,
                 "factor on the surroundings' light")
      ->check(number_from_zero)
      ->capture_default_str();
  std::string background;
  app.add_option(
      "--background", background,
      "what is seen behind the scene: environment, or light of one colour, RRGGBB, which is exposed and "
      "tone-mapped like the rest");
  app.add_option(
         "--samples", options.samples,
         "samples per pixel, at most; what the device has decides, and from a visibility buffer it is 1 or 4")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  std::string raster = "auto";
  app.add_option(
         "--raster", raster,
         "how triangles are drawn: by compute into a visibility buffer, or by the forward raster pipeline")
      ->check(CLI::IsMember(passes::kRasterPathNames))
      ->capture_default_str();
  std::string cull = "on";
  app.add_option(
         "--cull", cull,
         "leave out clusters that cannot be seen: those out of view, and (hidden; on: in large scenes) "
         "those behind others; the image is the same")
      ->check(CLI::IsMember(passes::kCullNames))
      ->capture_default_str();
  std::string levels_of_detail = "auto";
  app.add_option("--lod", levels_of_detail,
                 "levels of detail: coarser triangles where the difference is less than a pixel, in scenes "
                 "where they "
                 "pay or (on) in all; everywhere: in lights' maps, too, which may then be wrong within a "
                 "quarter of a "
                 "texel; off draws each triangle of the file")
      ->check(CLI::IsMember(passes::kLevelsOfDetailNames))
      ->capture_default_str();
  app.add_option("--anisotropy", options.anisotropy,
                 "anisotropic texture filtering, 1 to 16; from 2 on devices differ in what they draw")
      ->check(anisotropy_number)
      ->capture_default_str();
  std::string shadows = "auto";
  app.add_option("--shadows", shadows,
                 "shadows by rays (by ray query or a ray-tracing pipeline) or by maps alone")
      ->check(CLI::IsMember(passes::kShadowNames))
      ->capture_default_str();
  std::string shadow_rays = "hybrid";
  app.add_option("--shadow-rays", shadow_rays,
                 "hybrid: rays only where a map cannot tell; all: one for every lit surface")
      ->check(CLI::IsMember({"hybrid", "all"}))
      ->capture_default_str();
  app.add_option("--exposure", options.exposure, "factor on all light")
      ->check(positive_number)
      ->capture_default_str();
  std::string tone_map = "reinhard";
  app.add_option("--tone-map", tone_map, "how HDR light becomes display colour")
      ->check(CLI::IsMember({"reinhard", "aces", "neutral", "none"}))
      ->capture_default_str();
  std::string fxaa = "on";
  app.add_option("--fxaa", fxaa, "smooths edges in the finished image")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  std::string debug_view = "none";
  app.add_option("--view", debug_view,
                 "show something else than light: docs/views.md says what the colours of each stand for")
      ->check(CLI::IsMember(passes::kDebugViewNames))
      ->capture_default_str();

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const bool asked_for = error.get_exit_code() == 0;  // --help, --version
    if (asked_for) return app.exit(error);
    std::cerr << "fire3dv: " << error.what() << " (see fire3dv --help)\n";
    return kUsageError;
  }
  auto usage_error = [](const std::string& text) {
    std::cerr << "fire3dv: " << text << " (see fire3dv --help)\n";
    return kUsageError;
  };
  if (!parse_image_size(size, options.width, options.height)) {
    return usage_error("--size " + size + ": must be WxH with sides of 1 to " +
                       std::to_string(kMaxImageSide) + ", such as 1280x720");
  }
  if (!background.empty() && !parse_background(background, options.background)) {
    return usage_error("--background " + background + ": must be environment or a colour such as 20a0ff");
  }
  if (animate->count() > 0 && options.scene.empty()) {  // "--animate SCENE": the scene is no animation's name
    options.scene = std::exchange(options.animate, "all");
  }
  if (animate->count() > 0 && options.animate.empty()) options.animate = "all";
  options.wait_for_stream = wait_for_stream->count() > 0;
  if (!stream_timeout.empty()) {
    if (const std::string wrong = positive_number(stream_timeout); wrong.empty()) {
      options.stream_timeout = std::chrono::duration<double>(std::stod(stream_timeout));
    } else if (options.scene.empty()) {  // "--wait-for-stream SCENE": the scene is not a number
      options.scene = stream_timeout;
    } else {
      return usage_error("--wait-for-stream: " + wrong);
    }
  }
  const bool replays = !options.recording.replay.empty();
  if (options.scene.empty() && needs_scene && !replays && !options.list_devices)
    return usage_error("name a scene: fire3dv SCENE.glb");
  for (const std::string& text : peer_limits) {
    if (Result<void> set = set_limit(text, options.peer_limits); !set)
      return usage_error("--peer-limit: " + set.error().message);
  }
  for (const CLI::Option* option : {models, name_space, package_path}) {
    if (option->count() > 0 && !is_description(options.scene))
      return usage_error(option->get_name() + " needs a scene that is a description: .yaml, .urdf or .xml");
  }
  if (wanted_outputs->count() > 0) {
    if (options.out.empty()) return usage_error("--outputs needs a folder for them: --out DIR");
    Result<passes::ImageOutputs> parsed = passes::parse_image_outputs(outputs);
    if (!parsed) return usage_error("--outputs: " + parsed.error().message);
    options.outputs = *parsed;
  }
  if (options.cache.empty()) return usage_error("--cache: name a folder, or auto, beside or off");
  if (options.recording.step) options.lockstep = true;
  const bool receives = !options.listen.empty() || replays;
  if (options.lockstep && !receives) return usage_error("--lockstep needs a --listen URI or a --replay file");
  if (options.exit_when_done && !receives)
    return usage_error("--exit-when-done needs a --listen URI or a --replay file");
  if (options.wait_for_stream && (!receives || options.on_request))
    return usage_error("--wait-for-stream needs a --listen URI or a --replay file, and excludes --on-request");
  if (!options.recording.record.empty() && !receives)
    return usage_error("--record needs a --listen URI or a --replay file");
  if (const auto wrong = check_recording_options(options.recording)) return usage_error(*wrong);
  if (!options.devices.empty() && options.listen.empty())
    return usage_error("--devices spreads images that simulators ask for: it needs a --listen URI");
  if (options.on_request && (!options.headless || options.listen.empty() || !options.out.empty()))
    return usage_error("--on-request needs --headless and a --listen URI, and excludes --out");
  if (options.on_request && options.frames != 0)
    return usage_error(
        "--frames counts images that are drawn unasked, and --on-request draws none: leave one out");
  options.panels = gui == "on";
  if (const auto wrong = take_window_options(stereo, present, options)) return usage_error(*wrong);
  if (options.headless && (!stereo.empty() || windows->count() > 0 || screenshots->count() > 0))
    return usage_error("--window, --stereo and --screenshots need a window: leave --headless out");
  if ((camera->count() > 0) + (windows->count() > 0) + !stereo.empty() > 1)
    return usage_error("--camera, --window and --stereo exclude one another");
  options.raster = passes::raster_path_named(raster);
  options.cull = passes::cull_named(cull);
  options.levels_of_detail = passes::levels_of_detail_named(levels_of_detail);
  if (play == "latest") options.play.mode = PlayOptions::Mode::latest;
  if (play == "interpolate") options.play.mode = PlayOptions::Mode::interpolate;
  if (mark_held == "on") options.play.mark_held = MarkHeld::on;
  if (mark_held == "off") options.play.mark_held = MarkHeld::off;
  if (*fixed_delay) {
    if (!(delay_ms >= 0 && delay_ms <= 10'000))
      return usage_error("--delay must be a number from 0 to 10000");
    options.play.delay_ns = static_cast<int64_t>(delay_ms * 1e6);
  }
  if (options.lockstep && play == "interpolate")
    return usage_error("--play interpolate and --lockstep (or --step) exclude each other");
  options.async_compute = async_compute_named(async_compute);
  options.shadows = passes::shadows_named(shadows);
  options.shadows.hybrid = shadow_rays == "hybrid";
  options.tone_map = tone_map_named(tone_map);
  options.fxaa = fxaa == "on";
  options.debug_view = passes::debug_view_named(debug_view);
  const bool shows_light = options.debug_view == passes::DebugView::none;
  if (!shows_light && (!options.outputs.color_srgb8 || options.outputs[passes::Plane::color_linear_f16]))
    return usage_error(
        "--view shows something else than light: --outputs needs color and not linear beside it");
  if (!shows_light && options.on_request)
    return usage_error("--view is for images that are drawn unasked, and --on-request draws none");
  return options;
}

}  // namespace fire3dv::app
