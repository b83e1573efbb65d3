#include "renderer/app/start.h"

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <optional>

#include "base/files.h"
#include "base/log.h"
#include "base/plural.h"
#include "renderer/app/frame_loop.h"
#include "renderer/app/options/overlay_options.h"
#include "renderer/app/recording.h"
#include "renderer/app/renderer_metrics.h"
#include "renderer/app/run/run_parts.h"
#include "renderer/app/stop_signals.h"
#include "renderer/app/viewer_document.h"
#include "renderer/browser/live_view.h"
#include "renderer/browser/renderer_switch.h"
#include "renderer/browser/server/server.h"
#include "renderer/camera/default_look.h"
#include "renderer/editing/new_objects.h"
#include "renderer/editing/scene_editor.h"
#include "renderer/editing/viewer_edits.h"
#include "renderer/gpu/device/device.h"
#include "renderer/images/image_service.h"
#include "renderer/images/secondary_devices.h"
#include "renderer/loading/disk_caches.h"
#include "renderer/loading/scene_reload.h"
#include "renderer/passes/texture_capacity.h"
#include "renderer/scene/derived/variants.h"
#include "renderer/sinks/file_sink.h"
#include "renderer/sinks/frame.h"
#include "renderer/window/viewer_control.h"
#include "renderer/window/window_view.h"

namespace fire3dv::app {
namespace {

// State that persists when the user opens another scene.
struct Stage {
  gpu::Instance& instance;
  gpu::Device& device;
  std::optional<passes::SceneRenderer>& renderer;
  FrameStats& stats;
  const CacheLocations& places;
  Windows& windows;
  gui::Viewer& viewer;
  SecondaryDevices& further;
  const std::shared_ptr<BudgetPool> budgets;  // of all adapters
  std::unique_ptr<RendererMetrics> metrics;   // null: no metrics
  std::unique_ptr<serve::Server> server;      // null: no live view
  bool first = true;                          // no scene has been shown yet
  int exit_code = 0;                          // 1 after an error that did not end the run

  void note_start(const char* what) const {
    if (!first) return;
    const auto since = std::chrono::steady_clock::now() - begun;
    stats.note_start(what, std::chrono::duration<double, std::milli>(since).count());
  }
  std::chrono::steady_clock::time_point begun;
};

// Retries with an empty option if a later scene lacks the named object.
template <typename Value, typename Make>
Result<Value> make_or_default(const Stage& stage, Options& options, std::string Options::*name, Make&& make) {
  Result<Value> made = make(options);
  if (made || stage.first) return made;
  log_message(warning(made.error().message));
  (options.*name).clear();
  return make(options);
}

// Uploads the scene and allocates render targets of this size.
Result<void> place_scene(const Stage& stage, const scene::LoadedScene& loaded, VkExtent2D extent) {
  try {
    if (Result<void> enough =
            passes::ensure_texture_capacity(stage.device, stage.viewer.draw, loaded.scene, stage.renderer);
        !enough)
      return enough;
    stage.renderer->set_scene(loaded.scene, loaded.derived);
    passes::Shortage shortage{};
    const Result<passes::PreparedFrame> prepared = stage.renderer->prepare({.extent = extent}, &shortage);
    if (prepared) return {};
    if (shortage == passes::Shortage::device_memory)
      return Error{"the device has no memory for images of " + std::to_string(extent.width) + "x" +
                   std::to_string(extent.height) + " with " +
                   counted(static_cast<uint64_t>(stage.renderer->samples()), "sample") +
                   " beside the scene: choose a smaller --size, or fewer --samples"};
    return prepared.error();
  } catch (const gpu::VulkanFailure& failure) {
    if (!gpu::is_out_of_memory(failure)) throw;
  }
  return Error{loaded.scene.source.string() + ": the device has no memory for it"};
}

// Places a scene. The device memory may not suffice for the old and the new scene together: the second
// attempt starts with a new renderer without a scene.
Result<void> upload_scene(const Stage& stage, const scene::LoadedScene& loaded, VkExtent2D extent) {
  if (stage.first) return place_scene(stage, loaded, extent);
  Result<void> placed;
  for (int attempt = 0; attempt < 2; ++attempt) {
    placed = place_scene(stage, loaded, extent);
    if (placed) break;
    stage.device.wait(stage.device.last_submitted());
    stage.renderer.reset();
    stage.device.retire_all_now();
    stage.renderer.emplace(stage.device, stage.viewer.draw);
  }
  return placed;
}

// Animations that play after a reload. The file may have lost them.
std::vector<uint32_t> animations_again(const Options& options, const scene::Scene& scene) {
  if (options.animate.empty()) return {};
  Result<std::vector<uint32_t>> chosen = state::choose_animations(scene, options.animate);
  if (chosen) return std::move(*chosen);
  log_message(warning(chosen.error().message));
  return {};
}

// Runs the frame loop until it ends. Returns the next scene that the user opened, or null. before: the
// previous scene, which is shown again after an error.
Result<std::unique_ptr<ViewerDocument>> play(Stage& stage, ViewerDocument& show,
                                             std::unique_ptr<ViewerDocument>& before,
                                             const std::string& why_again) {
  Options options = show.options();
  sinks::Window* const window = stage.windows.empty() ? nullptr : stage.windows.front().window.get();
  SceneLoad& load = show.load();
  Result<const scene::LoadedScene*> loaded = load.wait([&] {
    if (!window) return;
    sinks::Window::poll_events();
    if (window->should_close()) show.abandon();
  });
  if (!loaded && window && window->should_close()) return std::unique_ptr<ViewerDocument>();
  if (!loaded) return loaded.error();
  stage.note_start(load.is_cached() ? "scene from the cache" : "scene");
  for (const std::string& note : load.notes()) log_message(note);
  const scene::Scene* const scene = &(*loaded)->scene;
  log_scene_summary(show.title(), *scene);
  if (stage.viewer.draw.path) {
    for (const std::string& limit : passes::path_tracing_limits(*scene)) log_message(warning(limit));
  }

  using Animations = std::optional<Playing>;
  Result<Animations> animations = make_or_default<Animations>(
      stage, options, &Options::animate, [&](const Options& o) { return open_animations(o, *scene); });
  if (!animations) return animations.error();
  const std::vector<uint32_t> playing = *animations ? (*animations)->chosen : std::vector<uint32_t>();
  Result<state::EditDocument> overlay = load_overlay(options);
  if (!overlay) return overlay.error();
  Result<CameraRig> camera =
      make_or_default<CameraRig>(stage, options, &Options::camera, [&](const Options& o) {
        const std::string name = may_add_camera(*overlay, o.camera) ? std::string() : o.camera;
        return CameraRig::create(*scene, camera_start(view_defaults(o), *scene, name, playing));
      });
  if (!camera) return camera.error();
  if (const std::string line = set_exposure(options.exposure, *scene, stage.viewer.draw); !line.empty())
    log_message("info: " + line);
  state::PoseState poses(*scene);
  StreamReceiver receiver(poses, options.lockstep, options.play, stage.budgets);
  ViewerReplies replies(receiver);
  ImageRequestQueue requests(replies, image_abilities(*stage.renderer, traces_requests(options)));
  receiver.set_image_handler(&requests);
  const auto can_show_everywhere = [&stage](const scene::Scene& other) {
    Result<void> can = passes::check_texture_count(stage.device, other);
    for (const std::unique_ptr<SecondaryDevice>& each : stage.further.all()) {
      if (can) can = passes::check_texture_count(each->device(), other);
    }
    return can;
  };
  DocumentLoader next(show, stage.places, can_show_everywhere);
  if (!why_again.empty()) next.note(why_again);
  if (Result<void> listening = open_listeners(options, stage.first, stage.budgets, receiver, next);
      !listening)
    return listening.error();
  Result<std::unique_ptr<Recording>> recording = open_recording(options, show);
  if (!recording) return recording.error();
  if (*recording) {
    receiver.watch(
        [&](size_t listener, const transport::LinkEvent& event) { (*recording)->take(listener, event); });
  }
  std::unique_ptr<replay::ReplayLink> replayed = show.take_replay();
  replay::ReplayLink* const timeline = replayed.get();
  if (timeline) {
    log_message("replaying " + timeline->uri());
    receiver.add(std::move(replayed));
  }
  if (stage.first) {  // one instance counts over all scenes
    Result<std::unique_ptr<RendererMetrics>> metrics = open_metrics(options, stage.budgets);
    if (!metrics) return metrics.error();
    stage.metrics = std::move(*metrics);
    Result<std::unique_ptr<serve::Server>> server = open_live_view(options);
    if (!server) return server.error();
    stage.server = std::move(*server);
  }
  Result<std::unique_ptr<sinks::FileSink>> image_folder = open_image_folder(options);
  if (!image_folder) return image_folder.error();
  sinks::NullSink no_files;

  // Detaches the windows from the device on every exit path.
  struct Detach {
    const Windows& windows;
    ~Detach() {
      for (const OpenWindow& open : windows) open.window->detach();
    }
  } detach_at_end{stage.windows};
  for (const OpenWindow& open : stage.windows) {
    if (Result<void> attached = open.window->attach(stage.instance, stage.device); !attached)
      return attached.error();
  }

  VkExtent2D extent{options.width, options.height};
  if (window && window->framebuffer_extent().width != 0) extent = window->framebuffer_extent();
  if (Result<void> placed = upload_scene(stage, **loaded, extent); !placed) return placed.error();
  passes::SceneRenderer& renderer = *stage.renderer;
  renderer.apply(stage.viewer.draw);
  stage.further.forget_scene();
  stage.note_start("scene on the device");
  std::optional<state::RobotPose> robot;  // with a window, viewers or an overlay
  bool moves_robot = window || stage.server;
  LiveScene live(**loaded, poses, renderer, *camera,
                 {options.assets, passes::levels_for(options.levels_of_detail), renderer.max_textures(),
                  overlay_file(options, show.has_own_file()).path});
  SceneEditor editor(overlay_file(options, show.has_own_file()), std::move(*overlay));
  if (show.has_own_file()) editor.set_export({[&show] { return show.load().gltf_file(); }, options.scene});
  editor.set_shown_additions([&live] { return std::span(live.shown_additions()); },
                             [&live] { return std::span(live.added_materials()); });
  live.on_scene_replaced([&](const scene::Scene& before_it, const scene::Scene& after) {
    editor.replace_scene(stage.viewer, before_it, after, robot ? &*robot : nullptr);
    live.set_user_edits(edits_of(stage.viewer));
    receiver.set_scene(&after);
  });
  receiver.set_scene(scene);
  std::optional<SceneReload> reload;
  if (options.watch && show.has_own_file()) {
    SceneReload::Hooks hooks;
    hooks.load = [&show](std::function<bool()> stop) { return show.load_again(std::move(stop)); };
    hooks.keep = [&](std::unique_ptr<SceneLoad> shown) {
      if (const auto next_version = shown->wait(); next_version)
        camera->set_ground(camera_start(view_defaults(options), (*next_version)->scene, {}, {}).ground);
      if (moves_robot) {
        std::optional<state::RobotPose> next_robot = find_robot(*shown);
        editor.replace_robot(stage.viewer, live.scene(), robot ? &*robot : nullptr,
                             next_robot ? &*next_robot : nullptr);
        robot = std::move(next_robot);
        if (robot) (void)robot->set(stage.viewer.joints);
        live.set_user_edits(edits_of(stage.viewer));
      }
      show.keep(std::move(shown));
    };
    hooks.can_show = can_show_everywhere;
    hooks.animations = [&options](const scene::Scene& other) { return animations_again(options, other); };
    reload.emplace(load, std::move(hooks));
  }
  live.set_shows_markers(options.markers);
  if (*animations) live.set_animations((*animations)->player, (*animations)->chosen);
  if (!options.variant.empty()) {
    if (Result<uint32_t> variant = scene::find_variant((*loaded)->scene, options.variant); variant)
      live.set_loaded_variant(*variant);
  }
  load.begin_caching();
  moves_robot |= !editor.history().document().empty();
  if (moves_robot) robot = find_robot(load);
  editor.begin(stage.viewer, {*scene, poses.names(), robot ? &*robot : nullptr});
  live.set_user_edits(edits_of(stage.viewer));
  if (robot) robot->set(stage.viewer.joints);
  for (const std::string& note : editor.take_log_messages()) log_message(note);
  const bool has_additions = live.await_additions([&] {
    if (window) sinks::Window::poll_events();
    return stop_was_requested() || (window && window->should_close());
  });
  editor.report_start({live.scene(), poses.names(), robot ? &*robot : nullptr, live.added_materials()});
  for (const std::string& note : live.take_log_messages()) log_message(note);
  for (const std::string& note : editor.take_log_messages()) log_message(note);
  // A stopped run ends with its frame loop, without the camera.
  if (has_additions && may_add_camera(editor.history().document(), options.camera)) {
    if (Result<void> chosen =
            select_added_camera(options.camera, live.scene(), live.shown_additions(), *camera);
        !chosen)
      return chosen.error();
  }
  std::unique_ptr<WindowView> view;
  if (window) {
    Result<std::unique_ptr<WindowView>> made = WindowView::create(
        {stage.device, stage.renderer, poses, receiver, requests, live, *camera, stage.windows, stage.viewer,
         editor, window_view_options(options), playing, robot, stage.first});
    if (!made) return made.error();
    view = std::move(*made);
  }
  FrameLoop loop({.device = stage.device,
                  .renderer = renderer,
                  .poses = poses,
                  .receiver = receiver,
                  .requests = requests,
                  .scene = live,
                  .animations = *animations ? &*(*animations)->player : nullptr,
                  .robot = &robot,
                  .camera = *camera,
                  .sink = *image_folder ? static_cast<sinks::FrameSink&>(**image_folder) : no_files,
                  .window = view.get(),
                  .stats = stage.stats,
                  .options = options});
  std::optional<LiveView> live_view;
  if (stage.server)
    live_view.emplace(
        LiveView::Borrowed{*stage.server, replies, receiver, poses, requests, live, stage.viewer, robot,
                           renderer,
                           may_switch_renderer(options, stage.device)
                               ? renderer_switch({stage.device, stage.renderer, stage.viewer, requests, live})
                               : nullptr},
        *camera, std::filesystem::path(show.title()).filename().string());
  loop.show_in_browsers(live_view ? &*live_view : nullptr);
  loop.report_to(stage.metrics.get());
  loop.follow(timeline);
  loop.record_with(recording->get());
  loop.go_on_with(&next);
  loop.reload_with(reload ? &*reload : nullptr);
  if (Result<void> kept = loop.keep_checkpoints(); !kept) return kept.error();
  loop.spread_images_over(stage.further, stage.viewer.draw);
  before.reset();
  Result<void> finished = loop.run();
  for (const std::string& note : editor.finish()) log_message(note);
  if (*recording) {
    log_message((*recording)->finish());
    if (const std::optional<Error> fault = (*recording)->failure()) stage.exit_code = report_failure(*fault);
  }
  if (const std::optional<Error> fault = load.finish_caching()) log_cache_error(*fault);
  log_message(count_images(loop.images(), options, image_folder->get()) + "\n" + stage.stats.summary());
  if (*image_folder) warn_of_stale_frames(options, **image_folder);
  if (!finished) return finished.error();
  return loop.switches_document() ? next.take() : nullptr;
}

}  // namespace

int run(const Options& options) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file size limit then fails the write like a full disk
  if (Result<void> good = check_scene_file(options); !good) return report_failure(good.error());
  if (Result<state::EditDocument> overlay = load_overlay(options); !overlay)
    return report_failure(overlay.error());
  // The window determines the required Vulkan extensions.
  Result<Windows> windows = open_windows(options);
  if (!windows) return report_failure(windows.error());
  gpu::InstanceOptions instance_options;
  instance_options.validation = options.validation;
  if (!windows->empty()) instance_options.window_extensions = windows->front().window->instance_extensions();
  // Opens the scene before all slow steps.
  const CacheLocations places =
      find_cache_locations(options.cache, [](const char* name) { return std::getenv(name); });
  std::unique_ptr<ViewerDocument> show;
  if (!options.list_devices) {
    Result<std::unique_ptr<ViewerDocument>> opened = ViewerDocument::open(options, places);
    if (!opened) return report_failure(opened.error());
    show = std::move(*opened);
  }
  Result<std::unique_ptr<gpu::Instance>> instance = gpu::Instance::create(instance_options);
  if (show && show->load().has_failed())
    return report_failure(show->with_scene_name(show->load().wait().error()));
  if (!instance) return report_failure(instance.error());
  if (options.list_devices) return list_devices(**instance);

  int exit_code = 0;
  {
    // Cheap checks come first.
    Result<FrameStats> stats = FrameStats::create(options.stats);
    if (!stats) return report_failure(stats.error());
    Result<std::shared_ptr<const scene::EnvironmentImage>> environment =
        load_environment(options.environment);
    if (!environment) return report_failure(environment.error());

    // The scene loads while the device opens and pipelines compile.
    Result<OpenDevices> devices = open_devices(**instance, options);
    if (show->load().has_failed()) return report_failure(show->with_scene_name(show->load().wait().error()));
    if (!devices) return report_failure(devices.error());
    gpu::Device& device = *devices->first;
    if (options.path) {
      if (Result<void> can = passes::can_trace_paths(device); !can)
        return report_failure(Error{"--render path: " + can.error().message});
    }
    if (const std::string missing = lacking_ray_effects(device, options); !missing.empty())
      log_message(warning(missing));
    PipelineCacheFile pipelines(device, places.pipelines);
    if (pipelines.note()) log_message(warning(*pipelines.note()));
    gui::Viewer viewer;
    viewer.draw = draw_settings(options, std::move(*environment));
    viewer.paths = options.path.value_or(passes::PathSettings());
    viewer.paths.lens = options.lens;
    viewer.draw.cached_environments = environment_store(places.environments);
    std::optional<passes::SceneRenderer> renderer(std::in_place, device, viewer.draw);
    Result<SecondaryDevices> further = SecondaryDevices::open(
        **instance, devices->further, options.async_compute, places, viewer.draw, *renderer);
    if (!further) return report_failure(further.error());
    Stage stage{**instance, device,       renderer,
                *stats,     places,       *windows,
                viewer,     *further,     BudgetPool::create(options.peer_limits),
                nullptr,    nullptr,      true,
                0,          options.begun};
    stage.note_start("renderer");
    if (Result<void> can = renderer->can_take(passes::with_sources(options.outputs)); !can)
      return report_failure(Error{"--outputs: " + can.error().message});
    if (Result<void> can = renderer->can_show(options.debug_view); !can)
      return report_failure(Error{"--view: " + can.error().message});
    if (!options.lens.is_pinhole() && !options.path) {
      if (Result<void> can = renderer->can_blur(); !can)
        return report_failure(Error{"--f-number: " + can.error().message});
    }
    viewer.debug_view = options.debug_view;
    std::unique_ptr<ViewerDocument> before;
    std::string note;
    while (show) {
      const std::string why_again = std::exchange(note, {});
      Result<std::unique_ptr<ViewerDocument>> next = play(stage, *show, before, why_again);
      if (next) {
        before = std::exchange(show, std::move(*next));
      } else if (before) {
        note = next.error().message + "; the previous scene is shown again";
        show = std::move(before);
        if (Result<void> again = show->restart_epoch(); !again) note += ", but " + again.error().message;
      } else {
        if (!why_again.empty()) log_message(error_line(why_again));
        exit_code = report_failure(show->with_scene_name(next.error()));
        show.reset();
      }
      stage.first = false;
      forget_scene(viewer);
    }
    if (stage.exit_code != 0) exit_code = stage.exit_code;
    if (Result<void> stored = pipelines.keep(); !stored) log_cache_error(stored.error());
  }
  if (const uint64_t messages = (*instance)->validation_messages()) {
    exit_code = report_failure(Error{counted(messages, "validation message")});
  }
  return exit_code;
}

}  // namespace fire3dv::app
