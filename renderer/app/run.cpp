#include "renderer/app/run.h"

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <optional>

#include "protocol/replay/replay_link.h"
#include "protocol/transport/open.h"
#include "renderer/app/cache_places.h"
#include "renderer/app/frame_loop.h"
#include "renderer/app/image_service.h"
#include "renderer/app/pipeline_file.h"
#include "renderer/app/recorded_scene.h"
#include "renderer/app/recording.h"
#include "renderer/app/renderer_metrics.h"
#include "renderer/app/scene_load.h"
#include "renderer/app/start.h"
#include "renderer/gpu/device.h"
#include "renderer/sinks/file_sink.h"
#include "renderer/sinks/null_sink.h"
#include "renderer/sinks/window.h"

namespace fire3dv::app {
namespace {

int list_devices(const gpu::Instance& instance) {
  const std::vector<gpu::DeviceReport> reports = gpu::report_devices(instance.handle());
  if (reports.empty()) {
    return fail(
        Error{"no Vulkan device found: install your GPU's driver, or mesa-vulkan-drivers for the CPU"});
  }
  for (const gpu::DeviceReport& report : reports) std::printf("%s\n", gpu::describe(report).c_str());
  return 0;
}

Result<void> open_listeners(const Options& options, StreamIntake& intake) {
  for (const std::string& uri : options.listen) {
    transport::ListenerOptions listener_options;
    const bool wants_all = options.lockstep || !options.recording.record.empty();
    listener_options.delivery = wants_all ? transport::Delivery::all : transport::Delivery::newest;
    listener_options.insecure = options.insecure;
    listener_options.key_file = options.key_file;
    listener_options.tls = {options.tls_certificate, options.tls_key, options.tls_client_ca};
    Result<std::unique_ptr<transport::ListenerLink>> listener =
        transport::open_listener(uri, listener_options);
    if (!listener) return listener.error();
    say("listening on " + (*listener)->uri());
    intake.add(std::move(*listener));
  }
  return {};
}

// Null without the option.
Result<std::unique_ptr<replay::ReplayLink>> open_replay(const Options& options) {
  const RecordingOptions& recording = options.recording;
  if (recording.replay.empty()) return std::unique_ptr<replay::ReplayLink>();
  replay::ReplayOptions replay_options;
  replay_options.streams = recording.streams;
  replay_options.speed = recording.speed;
  replay_options.start_s = recording.start_s;
  replay_options.end_s = recording.end_s;
  replay_options.loop = recording.loop;
  replay_options.each_frame = recording.step;
  replay_options.end_streams = options.exit_when_done;
  return replay::ReplayLink::open(recording.replay, replay_options);
}

// Null without the option.
Result<std::unique_ptr<Recording>> open_recording(const Options& options,
                                                  const std::filesystem::path& scene) {
  if (options.recording.record.empty()) return std::unique_ptr<Recording>();
  return Recording::open(options.recording, scene);
}

// Null without the option.
Result<std::unique_ptr<RendererMetrics>> open_metrics(const Options& options) {
  if (options.metrics.empty()) return std::unique_ptr<RendererMetrics>();
  Result<std::unique_ptr<RendererMetrics>> opened = RendererMetrics::open(options.metrics, options.insecure);
  if (opened) say("metrics at http://" + (*opened)->address() + "/metrics");
  return opened;
}

Result<std::unique_ptr<sinks::FrameSink>> open_sink(const Options& options) {
  if (options.out.empty()) return std::unique_ptr<sinks::FrameSink>(std::make_unique<sinks::NullSink>());
  sinks::FileSinkOptions file_options;
  file_options.folder = options.out;
  Result<std::unique_ptr<sinks::FileSink>> sink = sinks::FileSink::open(file_options);
  if (!sink) return sink.error();
  return std::unique_ptr<sinks::FrameSink>(std::move(*sink));
}

}  // namespace

int run(const Options& options) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of its write, as a full disk is
  // A window, when there is one, says which Vulkan extensions it needs.
  std::unique_ptr<sinks::Window> window;
  if (!options.headless && !options.list_devices) {
    Result<std::unique_ptr<sinks::Window>> opened =
        sinks::Window::open("FIRE-3DV", {options.width, options.height});
    if (!opened) return fail(opened.error());
    window = std::move(*opened);
  }
  gpu::InstanceOptions instance_options;
  instance_options.validation = options.validation;
  if (window) instance_options.window_extensions = window->instance_extensions();
  // What there is to show, before anything that takes long.
  Result<std::unique_ptr<replay::ReplayLink>> replayed = open_replay(options);
  if (!replayed) return fail(replayed.error());
  std::filesystem::path scene_path = options.scene;
  std::unique_ptr<RecordedScene> recorded_scene;
  if (scene_path.empty() && *replayed) {
    Result<std::unique_ptr<RecordedScene>> extracted =
        RecordedScene::extract((*replayed)->playback().reader());
    if (!extracted) return fail(extracted.error());
    recorded_scene = std::move(*extracted);
    scene_path = recorded_scene->path();
    say("scene \"" + recorded_scene->name() + "\" of " + options.recording.replay);
  }
  const CachePlaces places = cache_places(options.cache, [](const char* name) { return std::getenv(name); });
  std::optional<SceneLoad> load;
  if (!options.list_devices) {
    load.emplace(scene_path, options.convert, places.scenes, passes::levels_for(options.levels_of_detail),
                 stop_was_requested);
  }
  Result<std::unique_ptr<gpu::Instance>> instance = gpu::Instance::create(instance_options);
  if (load && load->has_failed()) return fail(load->wait().error());
  if (!instance) return fail(instance.error());
  if (options.list_devices) return list_devices(**instance);

  int exit_code = 0;
  {
    // The cheap things that can be wrong come first.
    Result<FrameStats> stats = FrameStats::create(options.stats);
    if (!stats) return fail(stats.error());
    const auto note_start = [&](const char* what) {
      const auto since = std::chrono::steady_clock::now() - options.begun;
      stats->note_start(what, std::chrono::duration<double, std::milli>(since).count());
    };
    Result<std::shared_ptr<const scene::EnvironmentImage>> environment =
        load_surroundings(options.environment);
    if (!environment) return fail(environment.error());

    // The scene loads while the device opens and its pipelines are made.
    Result<std::unique_ptr<gpu::Device>> device = open_device(**instance, options);
    if (load->has_failed()) return fail(load->wait().error());
    if (!device) return fail(device.error());
    PipelineFile pipelines(**device, places.pipelines);
    if (pipelines.note()) say(*pipelines.note());
    const passes::DrawSettings settings = draw_settings(options, std::move(*environment));
    std::optional<passes::SceneRenderer> renderer(std::in_place, **device, settings);
    note_start("renderer");
    if (Result<void> can = renderer->can_take(passes::with_sources(options.outputs)); !can)
      return fail(Error{"--outputs: " + can.error().message});
    if (Result<void> can = renderer->can_show(options.debug_view); !can)
      return fail(Error{"--view: " + can.error().message});
    Result<const scene::LoadedScene*> loaded = load->wait();
    if (!loaded) return fail(loaded.error());
    note_start(load->was_kept() ? "scene from the cache" : "scene");
    for (const std::string& note : load->notes()) say(note);
    const scene::Scene* const scene = &(*loaded)->scene;
    describe(scene_path, *scene);

    Result<CameraRig> camera = CameraRig::create(*scene, options.camera);
    if (!camera) return fail(camera.error());
    Result<std::optional<Playing>> animations = open_animations(options, *scene);
    if (!animations) return fail(animations.error());
    state::PoseState poses(*scene);
    StreamIntake intake(poses, options.lockstep, options.play);
    intake.offer_images(image_abilities());
    if (Result<void> listening = open_listeners(options, intake); !listening) return fail(listening.error());
    Result<std::unique_ptr<Recording>> recording = open_recording(options, scene_path);
    if (!recording) return fail(recording.error());
    if (*recording) {
      intake.watch(
          [&](size_t listener, const transport::LinkEvent& event) { (*recording)->take(listener, event); });
    }
    replay::ReplayLink* const timeline = replayed->get();
    if (timeline) {
      say("replaying " + timeline->uri());
      intake.add(std::move(*replayed));
    }
    Result<std::unique_ptr<RendererMetrics>> metrics = open_metrics(options);
    if (!metrics) return fail(metrics.error());
    Result<std::unique_ptr<sinks::FrameSink>> sink = open_sink(options);
    if (!sink) return fail(sink.error());

    // However this ends, the window lets go of the device first.
    struct Detach {
      sinks::Window* window;
      ~Detach() {
        if (window) window->detach();
      }
    } detach_at_end{window.get()};
    if (window) {
      if (Result<void> attached = window->attach(**instance, **device); !attached)
        return fail(attached.error());
    }

    if (Result<void> enough = make_room(**device, settings, *scene, renderer); !enough)
      return fail(enough.error());
    renderer->set_scene(*scene, (*loaded)->derived);
    note_start("scene on the device");
    LiveScene live(**loaded, poses, *renderer, *camera,
                   {options.assets, passes::levels_for(options.levels_of_detail), renderer->most_textures()});
    if (*animations) live.keep_playing((*animations)->player, (*animations)->chosen);
    load->begin_keeping();
    FrameLoop loop(**device, *renderer, poses, intake, live, *animations ? &*(*animations)->player : nullptr,
                   *camera, **sink, window.get(), *stats, options);
    loop.report_to(metrics->get());
    loop.follow(timeline);
    loop.record_with(recording->get());
    Result<void> finished = loop.run();
    if (!finished) exit_code = fail(finished.error());
    if (*recording) say((*recording)->finish());
    if (Result<void> kept = pipelines.keep(); !kept) say_of_cache(kept.error());
    if (const std::optional<Error> fault = load->finish_keeping()) say_of_cache(*fault);
    say(std::to_string(loop.images()) + " images" +
        (options.out.empty() ? "" : " in " + options.out.string()) + "\n" + stats->summary());
  }
  if (const uint64_t messages = (*instance)->validation_messages()) {
    exit_code = fail(Error{std::to_string(messages) + " validation messages"});
  }
  return exit_code;
}

}  // namespace fire3dv::app
