#include "base/log.h"
#include "base/plural.h"
#include "base/process/progress.h"
#include "renderer/offline/commands.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>
#include <system_error>
#include <vector>

#include "base/digest.h"
#include "base/process/stop_deadline.h"
#include "protocol/wire/check.h"
#include "renderer/app/device_uploader.h"
#include "renderer/app/options/appearance_options.h"
#include "renderer/app/start.h"
#include "renderer/app/stop_signals.h"
#include "renderer/camera/default_look.h"
#include "renderer/editing/asset_digest.h"
#include "renderer/editing/new_objects.h"
#include "renderer/editing/overlay_file.h"
#include "renderer/editing/target_index.h"
#include "renderer/gpu/selection/required_gpu.h"
#include "renderer/images/following_renderer.h"
#include "renderer/live_scene/asset_files.h"
#include "renderer/loading/disk_caches.h"
#include "renderer/offline/frame_folder.h"
#include "renderer/offline/offline_loop.h"
#include "renderer/offline/output_frames.h"
#include "renderer/offline/recorded_streams.h"
#include "renderer/offline/timeline.h"
#include "renderer/passes/outputs/outputs_pass.h"
#include "renderer/passes/path/path_pass.h"
#include "renderer/passes/texture_capacity.h"
#include "renderer/passes/view/framing.h"
#include "renderer/scene/cache/scene_digest.h"
#include "renderer/scene/derived/variants.h"
#include "renderer/sinks/video/video_sink.h"

namespace fire3dv::offline {
namespace {

std::string seconds(int64_t ns) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3f s", static_cast<double>(ns) * 1e-9);
  return text;
}

Result<record::Playback> open_recording(const RenderOptions& options) {
  auto source = record::open_source(options.recording);
  if (!source) return source.error();
  return record::Playback::open(std::move(*source));
}

Result<Timeline> read_timeline(record::Playback& playback, const RenderOptions& options) {
  const std::string& damage = playback.reader().index().damage;
  if (!damage.empty()) log_message("warning: " + damage + "; what is whole is rendered");
  Progress progress("fire3dv", "reading " + wire::printable(options.recording) + ":");
  auto timeline = Timeline::read(
      playback, options.clock,
      [&](uint64_t done, uint64_t total) {
        progress.update("", done, total);
        return !app::stop_was_requested();
      },
      !options.rate);
  if (!timeline) return timeline;
  if (timeline->damaged() != 0)
    log_message("warning: " + counted(timeline->damaged(), "damaged chunk") + " left out");
  for (const std::string& note : timeline->unusable_notes()) log_message("warning: " + note);
  constexpr int64_t kLongPauseNs = 60 * kSecondNs;
  const Timeline::Pause& pause = timeline->longest_pause();
  if (pause.length_ns > kLongPauseNs)
    log_message("warning: stream \"" + wire::printable(timeline->guide()) + "\" has no frame for " +
                seconds(pause.length_ns) + ", from " + seconds(pause.from_ns - timeline->first_ns()) +
                " after the start on: its last frame is held; render the parts with --start and --end");
  return timeline;
}

// timeline null: the scene at rest, or its animation from --start to --end.
Result<FrameTimes> choose_times(const Timeline* no_timeline, const RenderOptions& options) {
  if (!no_timeline && options.images) {
    FrameTimes times;
    times.frames = *options.images;
    return times;
  }
  if (!no_timeline) {
    const auto first_ns = static_cast<int64_t>(std::llround(options.start_s * 1e9));
    const auto last_ns = static_cast<int64_t>(std::llround(options.end_s.value_or(options.start_s) * 1e9));
    return frame_times(first_ns, last_ns, options.rate.value_or(FrameRate{}));
  }
  const Timeline& timeline = *no_timeline;
  if (options.choose_times) return options.choose_times(timeline);
  const int64_t length_ns = timeline.last_ns() - timeline.first_ns();
  const auto into = [&](double at_s) {
    return timeline.first_ns() + static_cast<int64_t>(std::llround(at_s * 1e9));
  };
  const double length_s = static_cast<double>(length_ns) * 1e-9;
  if (options.start_s > length_s)
    return Error{"--start: the recording is " + seconds(length_ns) + " of simulated time long"};
  const int64_t last_ns =
      options.end_s && *options.end_s < length_s ? into(*options.end_s) : timeline.last_ns();
  const int64_t first_ns = std::min(into(options.start_s), last_ns);
  if (options.rate) return frame_times(first_ns, last_ns, *options.rate);
  auto times = recorded_frame_times(first_ns, last_ns, timeline.recorded_ns());
  if (times && times->frames == 0)
    return Error{"no frame of stream \"" + wire::printable(timeline.guide()) +
                 "\" is recorded in that part: choose another with --start and --end, or set --rate"};
  return times;
}

std::string schedule_text(const FrameTimes& times, const Timeline* timeline, bool is_at_rest) {
  std::string text = counted(times.frames, "frame");
  if (!timeline)
    return times.frames == 1 || is_at_rest ? text + " of the scene" : text + " of the scene's animation";
  if (!times.is_recorded) text += ", " + to_text(times.rate) + " a second";
  return text + " of \"" + wire::printable(timeline->guide()) + "\"'s time, from " + seconds(times.first_ns);
}

// Manifest without the machine: all inputs that determine the bytes of frames.
Result<Manifest> describe_frames(const RenderOptions& options, const Timeline* timeline,
                                 const FrameTimes& times, const scene::Scene& scene,
                                 const state::EditDocument& edits) {
  constexpr uint64_t kMaxBytes = uint64_t{1} << 50;
  const auto digest_of = [](const std::filesystem::path& file) -> Result<std::string> {
    auto digest = digest_of_file(file, kMaxBytes);
    if (!digest) return digest.error();
    return hex(*digest).substr(0, 32);
  };
  Manifest manifest;
  manifest.settings = {{"program", std::string("fire3dv ") + FIRE3DV_VERSION}};
  if (timeline) {
    const auto recording = digest_of(options.recording);
    if (!recording) return recording.error();
    manifest.settings.emplace_back("recording", *recording);
  }
  manifest.settings.emplace_back("scene", scene::content_digest(scene));
  if (timeline) manifest.settings.emplace_back("clock", timeline->guide());
  manifest.settings.emplace_back("look", options.look);
  if (timeline && options.frames_motion) manifest.settings.emplace_back("frame-motion", "on");
  if (!options.drawing.environment.empty()) {
    const auto environment = digest_of(options.drawing.environment);
    if (!environment) return environment.error();
    manifest.settings.emplace_back("environment", *environment);
  }
  if (!options.drawing.overlay.empty()) {
    const auto overlay = digest_of(options.drawing.overlay);
    if (!overlay) return overlay.error();
    manifest.settings.emplace_back("overlay", *overlay);
    const std::string added = app::digest_of_assets(edits, {options.drawing.assets, options.drawing.overlay},
                                                    app::stop_was_requested);
    if (!added.empty()) manifest.settings.emplace_back("digest of added assets", added);
  }
  manifest.times = times;
  manifest.width = options.drawing.width;
  manifest.height = options.drawing.height;
  manifest.shard = options.shard;
  manifest.shards = options.shards;
  return manifest;
}

// All settings and the times of frames, for checkpoints.
std::string inputs_of(const Manifest& manifest) {
  std::string text = std::to_string(manifest.times.first_ns) + " ns, " +
                     (manifest.times.is_recorded ? "recorded" : to_text(manifest.times.rate)) + "\n";
  for (const auto& [name, value] : manifest.settings) text += name + ": " + value + "\n";
  return text;
}

sinks::VideoSettings video_settings(const RenderOptions& options) {
  sinks::VideoSettings settings;
  settings.path = options.out;
  settings.codec = options.video.codec;
  settings.crf = options.video.crf;
  settings.full_chroma = options.video.full_chroma;
  settings.width = options.drawing.width;
  settings.height = options.drawing.height;
  settings.fps_numerator = options.rate->numerator;
  settings.fps_denominator = options.rate->denominator;
  return settings;
}

// Destination of frames: a consumer, a folder or a video.
struct Output {
  ImageConsumer* consumer = nullptr;
  std::unique_ptr<FrameFolder> folder;
  std::unique_ptr<sinks::VideoSink> video;
  sinks::FrameSink& sink() {
    if (consumer) return *consumer;
    return folder ? static_cast<sinks::FrameSink&>(*folder) : *video;
  }
  bool is_wanted(uint64_t image) const {
    return consumer ? consumer->is_wanted(image) : !folder || !folder->has(image);
  }
};

// Without the machine, which is opened later.
sinks::RunProvenance describe_run(const RenderOptions& options, const Manifest& manifest) {
  sinks::RunProvenance provenance;
  provenance.command = options.command;
  provenance.build = sinks::this_build();
  const auto add_file = [&](const char* name, const std::filesystem::path& path) {
    if (!path.empty()) provenance.files.emplace_back(name, path.filename().string());
  };
  add_file("recording", options.recording);
  add_file("scene", options.drawing.scene);
  for (const auto& setting : manifest.settings) {
    if (setting.first != "program" && setting.first != "look") provenance.inputs.push_back(setting);
  }
  provenance.options = options.own;
  for (const auto& [name, value] : app::appearance_options(options.drawing)) {
    if (!sinks::find_value(options.own, name)) provenance.options.emplace_back(name, value);
  }
  return provenance;
}

// Null, and a warning, if it is too long for images.
std::shared_ptr<const std::string> encode_run(sinks::RunProvenance provenance, const Machine& machine) {
  provenance.machine = {{"device", machine.device}, {"driver", machine.driver}, {"cpu", machine.cpu}};
  auto text = sinks::encode_provenance(provenance);
  if (!text)
    log_message(
        "warning: options and labels take more than 64 KiB: images carry no provenance, and fire3dv verify "
        "cannot check them");
  return text ? std::make_shared<const std::string>(std::move(*text)) : nullptr;
}

std::filesystem::path folder_of(const RenderOptions& options) {
  return options.resume ? std::filesystem::path(options.out.string() + ".frames") : options.out;
}

Result<Output> open_output(const RenderOptions& options, const Manifest& manifest,
                           const std::shared_ptr<FrameFormat>& format, ImageConsumer* consumer) {
  Output output;
  output.consumer = consumer;
  if (consumer) return output;
  if (format) {
    auto folder = FrameFolder::open(options.out, manifest, format);
    if (!folder) return folder.error();
    output.folder = std::move(*folder);
    return output;
  }
  const bool is_video = sinks::is_video_name(options.out);
  if (is_video && !options.resume) {
    auto video = sinks::VideoSink::open(video_settings(options));
    if (!video) return video.error();
    output.video = std::move(*video);
    return output;
  }
  // Checks the video settings before frames are rendered.
  if (is_video) {
    if (auto good = sinks::check_video_settings(video_settings(options)); !good) return good.error();
  }
  auto folder = FrameFolder::open(folder_of(options), manifest);
  if (!folder) return folder.error();
  output.folder = std::move(*folder);
  return output;
}

// Frames of another machine stay, with a warning.
void warn_of_other_machine(const FrameFolder& folder, const Machine& machine) {
  const auto& before = folder.machine_before();
  if (!before || *before == machine || folder.existing_frames() == 0) return;
  log_message("warning: the frames that are there were drawn by " + wire::printable(before->device) + " (" +
              wire::printable(before->driver) + ", " + wire::printable(before->cpu) +
              "), the others will be by " + machine.device + " (" + machine.driver + ", " + machine.cpu +
              "): they may differ in a pixel's last digits");
}

// Points of the scene at up to 24 frames of all shards, evenly spread, for a camera that frames all of the
// motion. What streams add to the scene is left out. Reads the recording once.
Result<std::vector<glm::vec3>> points_over_motion(const scene::Scene& scene,
                                                  const RecordedStreams::Open& open_recording,
                                                  const Timeline& timeline, const FrameTimes& times,
                                                  const std::function<bool()>& should_stop) {
  constexpr uint64_t kMaxSamples = 24;
  state::PoseState poses(scene);
  auto streams = RecordedStreams::open(open_recording, timeline, poses);
  if (!streams) return streams.error();
  std::vector<glm::vec3> points;
  std::vector<glm::mat4> world_from_node(scene.nodes.size());
  const uint64_t samples = std::min(times.frames, kMaxSamples);
  for (uint64_t i = 0; i < samples && !should_stop(); ++i) {
    const uint64_t frame = samples == 1 ? 0 : i * (times.frames - 1) / (samples - 1);
    streams->advance(times.at_ns(frame));
    for (uint32_t node = 0; node < world_from_node.size(); ++node)
      world_from_node[node] = poses.world_from_node(node);
    const std::vector<glm::vec3> moved = passes::framing_points(scene, world_from_node);
    points.insert(points.end(), moved.begin(), moved.end());
  }
  return points;
}

// Images of one camera with the outputs of fire3dv render --outputs.
class OutputImages final : public ImageSet {
 public:
  explicit OutputImages(wire::ImageOutputs outputs) : outputs_(outputs) {}

  wire::ImageOutputs outputs() const override { return outputs_; }
  const std::vector<std::string>& cameras() const override { return cameras_; }
  // Motion and occlusion are those since the image before.
  uint32_t flow_frames() const override { return outputs_.needs_last_image() ? 1 : 0; }
  bool has_flow_forward() const override { return false; }
  bool has_motion_planes() const override { return true; }
  Result<std::shared_ptr<FrameFormat>> open_format(const scene::Scene&, const std::filesystem::path&,
                                                   Settings& settings) override {
    settings.emplace_back(kOutputsSetting, outputs_text(outputs_));
    return std::shared_ptr<FrameFormat>(std::make_shared<OutputFrames>(outputs_));
  }
  Result<void> check_camera(size_t, const app::CameraRig::Placed&) const override { return {}; }
  void add_poses(uint64_t, const app::CameraRig::Placed&, const app::CameraRig::Placed*,
                 const state::PoseState&) override {}

 private:
  const wire::ImageOutputs outputs_;
  const std::vector<std::string> cameras_;  // none: that of the drawing options
};

class Render {
 public:
  Render(const RenderOptions& options, ImageSet* set, ImageConsumer* consumer)
      : options_(options),
        set_(set),
        consumer_(consumer),
        drawing_(options.drawing),
        cache_locations_(
            app::find_cache_locations(drawing_.cache, [](const char* name) { return std::getenv(name); })) {}

  Result<bool> run();  // false: stopped by the user
  bool validation_was_silent() const { return !instance_ || instance_->validation_messages() == 0; }

 private:
  Result<bool> draw(const app::SceneLoad& load, const scene::LoadedScene& loaded, const Timeline* timeline,
                    const Manifest& manifest, Output& output);
  Result<std::vector<app::CameraRig>> place_cameras(const scene::Scene& scene,
                                                    const std::vector<uint32_t>& animations) const;

  std::vector<std::string> camera_names() const {
    return set_ && !set_->cameras().empty() ? set_->cameras() : std::vector{drawing_.camera};
  }
  // A camera that the overlay adds is chosen later.
  std::string camera_of_file(const std::string& name) const {
    return app::may_add_camera(overlay_, name) ? std::string() : name;
  }

  const RenderOptions& options_;
  ImageSet* const set_;
  ImageConsumer* const consumer_;
  const app::Options& drawing_;
  sinks::RunProvenance provenance_;
  const app::CacheLocations cache_locations_;
  state::EditDocument overlay_;
  std::unique_ptr<gpu::Instance> instance_;
};

Result<bool> Render::run() {
  if (set_ && set_->flow_frames() != 0 && !drawing_.devices.empty())
    return Error{
        "--devices: flow and motion compare images of one device: name it by --device, and draw a part on "
        "each with --shard"};
  if (!drawing_.overlay.empty()) {
    auto overlay = state::load_overlay(drawing_.overlay);
    if (!overlay) return overlay.error();
    overlay_ = std::move(*overlay);
  }
  if (!drawing_.variant.empty()) overlay_[state::variant_key()] = drawing_.variant;
  std::optional<record::Playback> playback;
  if (!options_.recording.empty()) {
    auto opened = open_recording(options_);
    if (!opened) return opened.error();
    playback = std::move(*opened);
  }
  // The scene loads while the recording is read.
  auto scene = RecordingScene::open(drawing_, cache_locations_.scenes, playback ? &*playback : nullptr,
                                    app::stop_was_requested);
  if (!scene) return scene.error();
  app::SceneLoad& load = (*scene)->load();
  std::optional<Timeline> recorded;
  if (playback) {
    auto read = read_timeline(*playback, options_);
    if (!read) return read.error();
    recorded = std::move(*read);
  }
  const Timeline* const timeline = recorded ? &*recorded : nullptr;
  const auto times = choose_times(timeline, options_);
  if (!times) return times.error();
  auto loaded = load.wait();
  if (!loaded) return (*scene)->with_title(loaded.error());
  for (const std::string& note : load.notes()) log_message(note);
  std::unique_ptr<const scene::LoadedScene> prepared;
  if (set_) {
    auto made = set_->prepare_scene(**loaded);
    if (!made) return (*scene)->with_title(made.error());
    prepared = std::move(*made);
  }
  const scene::LoadedScene& shown = prepared ? *prepared : **loaded;
  app::log_scene_summary((*scene)->title(), shown.scene);
  // Checked before the output is made, so that a mistyped name leaves nothing.
  for (const std::string& name : camera_names()) {
    if (auto camera = app::CameraRig::create(shown.scene, {camera_of_file(name), false, {}, {}}); !camera)
      return (*scene)->with_title(camera.error());
  }
  auto manifest = describe_frames(options_, timeline, *times, shown.scene, overlay_);
  if (!manifest) return manifest.error();
  std::shared_ptr<FrameFormat> format;
  if (set_) {
    auto opened = set_->open_format(shown.scene, load.gltf_file(), manifest->settings);
    if (!opened) return (*scene)->with_title(opened.error());
    format = std::move(*opened);
    manifest->cameras = static_cast<uint32_t>(camera_names().size());
  }
  for (auto& [name, value] : manifest->settings) value = setting_text(value);
  if (app::stop_was_requested()) {
    log_message("stopped before the first frame");
    return false;
  }
  const Part part = manifest->part();
  log_message(schedule_text(*times, timeline, options_.images.has_value()) +
              (set_ ? ", " + counted(manifest->cameras, "camera") : std::string()) +
              (options_.shards > 1
                   ? "; shard " + std::to_string(options_.shard) + " of " + std::to_string(options_.shards) +
                         " has " + std::to_string(part.frames) + ", from frame " + std::to_string(part.first)
                   : ""));
  provenance_ = describe_run(options_, *manifest);
  if (consumer_) {
    const auto begun = consumer_->begin(*manifest, provenance_, format);
    if (!begun || !*begun) return begun;
  }
  auto output = open_output(options_, *manifest, format, consumer_);
  if (!output) return output.error();
  // A folder can be resumed; nothing is left of a video.
  const ExitTask finish_files([&output] {
    if (output->video) output->video->abandon();
    if (output->folder) (void)output->folder->finish();
    return 1;
  });

  if (!output->folder || output->folder->existing_frames() < part.frames) {
    auto drawn = draw(load, shown, timeline, *manifest, *output);
    if (!drawn || !*drawn) {
      if (output->video) output->video->abandon();
      return drawn ? drawn : (*scene)->with_title(drawn.error());
    }
    load.begin_caching();
    if (const auto fault = load.finish_caching()) app::log_cache_error(*fault);
  } else {
    // An empty shard has a manifest, too.
    if (part.frames == 0) {
      if (auto begun = output->folder->begin({}); !begun) return begun.error();
    }
    log_message(set_ ? "all images are there already" : "all frames are there already");
  }
  if (set_ && output->folder) {
    if (auto completed = output->folder->complete_run(); !completed) return completed.error();
  }
  if (options_.resume) return encode_and_clear(folder_of(options_), options_.out, options_.video);
  return true;
}

Result<std::vector<app::CameraRig>> Render::place_cameras(const scene::Scene& scene,
                                                          const std::vector<uint32_t>& animations) const {
  std::vector<app::CameraRig> cameras;
  for (const std::string& name : camera_names()) {
    auto camera = app::CameraRig::create(
        scene, app::camera_start(app::view_defaults(drawing_), scene, camera_of_file(name), animations));
    if (!camera) return camera.error();
    cameras.push_back(std::move(*camera));
  }
  return cameras;
}

Result<bool> Render::draw(const app::SceneLoad& load, const scene::LoadedScene& loaded,
                          const Timeline* timeline, const Manifest& manifest, Output& output) {
  auto environment = app::load_environment(drawing_.environment);
  if (!environment) return environment.error();
  gpu::InstanceOptions instance_options;
  instance_options.validation = drawing_.validation;
  auto instance = gpu::Instance::create(instance_options);
  if (!instance) return instance.error();
  instance_ = std::move(*instance);
  auto devices = app::open_devices(*instance_, drawing_);
  if (!devices) return devices.error();
  const std::unique_ptr<gpu::Device>* const device = &devices->first;
  const gpu::DeviceReport& report = (*device)->report();
  if (drawing_.draw.path) {
    if (auto can = passes::can_trace_paths(**device); !can)
      return Error{"--render path: " + can.error().message};
    for (const std::string& limit : passes::path_tracing_limits(loaded.scene)) log_message(warning(limit));
  }
  for (const std::string& unused : app::settings_without_effect(**device, drawing_))
    log_message(warning(unused));
  app::PipelineCacheFile pipelines(**device, cache_locations_.pipelines);
  if (pipelines.note()) log_message(warning(*pipelines.note()));
  settings::DrawSettings settings = drawing_.draw;
  settings.environment = std::move(*environment);
  if (const std::string line = app::set_exposure(drawing_.draw.post, loaded.scene, settings); !line.empty())
    log_message("info: " + line);
  settings.cached_environments = app::environment_store(cache_locations_.environments);
  std::optional<passes::SceneRenderer> renderer(std::in_place, **device, settings);
  if (auto enough = passes::ensure_texture_capacity(**device, settings, loaded.scene, renderer); !enough)
    return enough.error();
  renderer->set_scene(loaded.scene, loaded.derived);
  std::vector<std::unique_ptr<app::FollowingRenderer>> secondary;
  for (const uint32_t index : devices->secondary) {
    auto opened =
        app::FollowingRenderer::open(*instance_, index, drawing_.async_compute, cache_locations_, settings);
    if (!opened) return opened.error();
    if (auto alike = app::check_alike(*renderer, (*opened)->renderer()); !alike) return alike.error();
    secondary.push_back(std::move(*opened));
  }
  if (const std::string sun = app::describe_sun(*renderer); !sun.empty()) log_message("info: " + sun);
  if (auto prepared = renderer->prepare({.extent = {drawing_.width, drawing_.height}}); !prepared)
    return prepared.error();

  auto animations = app::open_animations(drawing_, loaded.scene);
  if (!animations) return animations.error();
  if (set_) {
    if (auto can = renderer->can_take(wire::with_sources(set_->outputs())); !can)
      return Error{(options_.command == "dataset" ? "a data set needs all labels: " : "--outputs: ") +
                   can.error().message};
    if (set_->changes() && set_->changes()->has_lens() && !drawing_.draw.path) {
      if (auto can = renderer->can_blur(); !can) return Error{"cameras with a lens: " + can.error().message};
    }
  }
  const FlowPlan flow = plan_flow(set_, camera_names().size(), {drawing_.width, drawing_.height});
  if (auto fits = check_flow_memory(flow, passes::snapshot_bytes(renderer->gpu_scene())); !fits)
    return fits.error();
  auto cameras = place_cameras(loaded.scene, *animations ? (*animations)->chosen : std::vector<uint32_t>());
  if (!cameras) return cameras.error();
  if (timeline && options_.frames_motion &&
      std::ranges::any_of(*cameras, [](const app::CameraRig& camera) { return camera.is_free(); })) {
    auto points = points_over_motion(
        loaded.scene, [&] { return open_recording(options_); }, *timeline, manifest.times,
        app::stop_was_requested);
    if (!points) return points.error();
    for (app::CameraRig& camera : *cameras) camera.set_framed_points(*points);
  }
  state::PoseState poses(loaded.scene);
  std::vector<const gpu::Device*> secondary_devices;
  std::vector<passes::SceneRenderer*> secondary_renderers;
  for (const auto& each : secondary) {
    secondary_devices.push_back(&each->device());
    secondary_renderers.push_back(&each->renderer());
  }
  app::DeviceUploader uploader(*renderer, secondary_devices);
  uploader.share_markers(secondary_renderers);
  app::LiveScene live(loaded, poses, uploader,
                      {drawing_.assets, passes::levels_for(drawing_.draw.levels_of_detail),
                       renderer->settings().draw().max_textures, drawing_.overlay});
  for (app::CameraRig& camera : *cameras) camera.set_edits(live.edits());
  live.on_scene_replaced([&](const scene::Scene&, const scene::Scene& after) {
    for (app::CameraRig& camera : *cameras) camera.set_scene(after);
  });
  live.set_shows_markers(drawing_.markers);
  if (*animations) live.set_animations((*animations)->player, (*animations)->chosen);
  if (!drawing_.variant.empty()) {
    if (const auto variant = scene::find_variant(loaded.scene, drawing_.variant); variant)
      live.set_loaded_variant(*variant);
  }
  std::optional<state::RobotPose> robot;
  if (!overlay_.empty()) robot = app::find_robot(load);
  const auto edit = [&](const scene::Scene& of, std::vector<state::EditKey>* unmatched) {
    const state::NodeNames names(of);
    const state::EditTargets targets{of, names, robot ? &*robot : nullptr, live.added_materials()};
    live.set_user_edits(state::to_edits(overlay_, targets, {}, unmatched));
  };
  live.on_scene_replaced([&](const scene::Scene&, const scene::Scene& after) { edit(after, nullptr); });
  std::vector<state::EditKey> unmatched;
  edit(loaded.scene, &unmatched);
  const bool has_additions = live.await_additions(app::stop_was_requested);
  for (const std::string& note : live.take_log_messages()) log_message(note);
  if (!has_additions) {
    if (!consumer_)
      log_message(output.folder ? "stopped; the same command goes on from here"
                                : "stopped; nothing is left of the video");
    return false;
  }
  for (size_t i = 0; i < cameras->size(); ++i) {
    const std::string name = camera_names()[i];
    if (!app::may_add_camera(overlay_, name)) continue;
    const Result<size_t> added = app::find_added_camera(name, live.scene(), live.shown_additions());
    if (!added) return added.error();
    (*cameras)[i].select(*added);
  }
  for (size_t i = 0; set_ && i < cameras->size(); ++i) {
    const float aspect = static_cast<float>(drawing_.width) / static_cast<float>(drawing_.height);
    if (auto good = set_->check_camera(i, (*cameras)[i].placed(poses, aspect)); !good) return good.error();
  }
  const state::NodeNames names(live.scene());
  const state::EditTargets targets{live.scene(), names, nullptr, live.added_materials()};
  state::TargetIndex index(targets);
  for (const state::EditKey& key : unmatched) {
    if (index.find(key) != scene::kNone) continue;  // of an addition
    log_message(warning(drawing_.overlay.string() + ": " + state::missing_target_text(key, targets)));
  }
  if (robot) robot->set(live.user_edits().joints);
  std::optional<RecordedStreams> streams;
  if (timeline) {
    auto opened = RecordedStreams::open([&] { return open_recording(options_); }, *timeline, poses);
    if (!opened) return opened.error();
    streams.emplace(std::move(*opened));
  }

  const Part part = manifest.part();
  const Machine machine{report.name, report.driver, sinks::cpu_name()};
  std::vector<std::shared_ptr<const std::string>> provenance{encode_run(provenance_, machine)};
  for (const gpu::Device* const each : secondary_devices) {
    if (each->report().name == report.name && each->report().driver == report.driver)
      provenance.push_back(provenance.front());
    else
      provenance.push_back(
          encode_run(provenance_, {each->report().name, each->report().driver, machine.cpu}));
  }
  if (output.folder) {
    warn_of_other_machine(*output.folder, machine);
    if (output.folder->existing_frames() > 0)
      log_message(counted(output.folder->existing_frames(), set_ ? "image" : "frame") + " are there already");
    if (auto begun = output.folder->begin(machine, provenance.front() ? *provenance.front() : ""); !begun)
      return begun.error();
  }
  std::optional<app::PathCheckpoint> checkpoint;
  if (drawing_.draw.path && output.folder && drawing_.checkpoint_interval_s > 0)
    checkpoint.emplace(folder_of(options_), drawing_, report, "", inputs_of(manifest));
  const auto replace_renderer = [&](const settings::DrawSettings& with) -> Result<void> {
    (*device)->wait((*device)->last_submitted());
    settings.environment = with.environment;
    settings.max_textures = renderer->settings().draw().max_textures;
    renderer.reset();
    (*device)->retire_all_now();
    renderer.emplace(**device, settings);
    renderer->set_edits(live.edits());
    renderer->set_scene(live.scene(), live.loaded().derived);
    if (auto prepared = renderer->prepare({.extent = {drawing_.width, drawing_.height}}); !prepared)
      return prepared.error();
    return {};
  };
  OfflineLoop loop(
      {**device, *renderer, secondary, settings.environment, poses, streams ? &*streams : nullptr, live,
       *animations ? &(*animations)->player : nullptr, *cameras, output.sink(),
       checkpoint ? &*checkpoint : nullptr, robot && robot->is_moved() ? &*robot : nullptr, set_,
       replace_renderer, !set_ || !set_->outputs().has_planes() || drawing_.markers_in_data_sets, provenance},
      manifest.times);
  const auto is_wanted = [&](uint64_t image) { return output.is_wanted(image); };
  auto drawn = loop.run(part, is_wanted, app::stop_was_requested);
  if (!drawn) return drawn;
  if (streams && streams->left_out() != 0)
    log_message("warning: " + std::to_string(streams->left_out()) +
                " scene edits were left out: too many stand between two frames");
  // An interrupted folder can be resumed, an interrupted video cannot.
  if (*drawn || output.folder) {
    if (auto finished = output.sink().finish(); !finished) return finished.error();
  }
  if (*drawn && checkpoint) checkpoint->remove();
  if (!consumer_)
    log_message(counted(loop.images(), set_ ? "image" : "frame") + " drawn for " + options_.out.string());
  if (!*drawn && !consumer_)
    log_message(output.folder ? "stopped; the same command goes on from here"
                              : "stopped; nothing is left of the video (--resume keeps what is drawn)");
  if (auto cached = pipelines.keep(); !cached) app::log_cache_error(cached.error());
  return drawn;
}

}  // namespace

int render(const RenderOptions& options, ImageSet* set, ImageConsumer* consumer) {
  if (options.drawing.require_gpu) {
    if (Result<void> found = gpu::check_required_gpu(options.drawing.device, options.drawing.devices);
        !found) {
      report_failure(found.error());
      return gpu::kNoGpuExitStatus;
    }
  }
  std::optional<OutputImages> outputs;
  if (!set && options.drawing.outputs != wire::ImageOutputs())
    set = &outputs.emplace(options.drawing.outputs);
  Render rendering(options, set, consumer);
  const Result<bool> done = rendering.run();
  if (!rendering.validation_was_silent()) return report_failure(Error{"validation messages; see above"});
  if (!done) return report_failure(done.error());
  return *done ? 0 : 1;
}

}  // namespace fire3dv::offline
