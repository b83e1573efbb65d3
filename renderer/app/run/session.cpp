#include "renderer/app/run/session.h"

#include <filesystem>
#include <functional>
#include <span>
#include <utility>

#include "base/log.h"
#include "base/plural.h"
#include "base/process/failure.h"
#include "renderer/app/options/overlay_options.h"
#include "renderer/app/run/live_provenance.h"
#include "renderer/app/run/run_parts.h"
#include "renderer/app/stop_signals.h"
#include "renderer/browser/renderer_switch.h"
#include "renderer/camera/default_look.h"
#include "renderer/editing/new_objects.h"
#include "renderer/editing/view_transfer.h"
#include "renderer/images/image_batch_renderer.h"
#include "renderer/passes/path/path_pass.h"
#include "renderer/passes/texture_capacity.h"
#include "renderer/scene/derived/variants.h"
#include "renderer/state/motion/animation.h"

namespace fire3dv::app {
namespace {

void log_messages(const std::vector<std::string>& messages) {
  for (const std::string& message : messages) log_message(message);
}

// Retries with an empty option if a later scene lacks the named object.
template <typename Value, typename Make>
Result<Value> make_or_default(const Application& application, Options& options, std::string Options::*name,
                              Make&& make) {
  Result<Value> made = make(options);
  if (made || application.is_first_document) return made;
  log_message(warning(made.error().message));
  (options.*name).clear();
  return make(options);
}

// Uploads the scene and allocates render targets of this size.
Result<void> upload_once(const Application& application, const scene::LoadedScene& loaded,
                         VkExtent2D extent) {
  std::optional<passes::SceneRenderer>& renderer = application.renderer;
  try {
    if (Result<void> enough = passes::ensure_texture_capacity(application.device, application.view_state.draw,
                                                              loaded.scene, renderer);
        !enough)
      return enough;
    renderer->set_scene(loaded.scene, loaded.derived);
    passes::Shortage shortage{};
    const Result<passes::PreparedFrame> prepared = renderer->prepare({.extent = extent}, &shortage);
    if (prepared) return {};
    if (shortage == passes::Shortage::device_memory)
      return Error{"the device has no memory for images of " + std::to_string(extent.width) + "x" +
                   std::to_string(extent.height) + " with " +
                   counted(static_cast<uint64_t>(renderer->settings().samples()), "sample") +
                   " beside the scene: choose a smaller --size, or fewer --samples"};
    return prepared.error();
  } catch (const gpu::VulkanFailure& failure) {
    if (!gpu::is_out_of_memory(failure)) throw;
  }
  return Error{loaded.scene.source.string() + ": the device has no memory for it"};
}

// The device memory may not suffice for the previous and the new scene together: the second attempt starts
// with a new renderer without a scene.
Result<void> upload_scene(const Application& application, const scene::LoadedScene& loaded,
                          VkExtent2D extent) {
  if (application.is_first_document) return upload_once(application, loaded, extent);
  Result<void> uploaded;
  for (int attempt = 0; attempt < 2; ++attempt) {
    uploaded = upload_once(application, loaded, extent);
    if (uploaded) break;
    application.device.wait(application.device.last_submitted());
    application.renderer.reset();
    application.device.retire_all_now();
    application.renderer.emplace(application.device, application.view_state.draw);
  }
  return uploaded;
}

// Animations that play after a reload. The file may have lost them.
std::vector<uint32_t> animations_of_reloaded(const Options& options, const scene::Scene& scene) {
  if (options.animate.empty()) return {};
  Result<std::vector<uint32_t>> chosen = state::choose_animations(scene, options.animate);
  if (chosen) return std::move(*chosen);
  log_message(warning(chosen.error().message));
  return {};
}

// Checks the scene for all devices of the run.
Result<void> can_show(const Application& application, const scene::Scene& scene) {
  Result<void> can = passes::check_texture_count(application.device, scene);
  for (const std::unique_ptr<SecondaryDevice>& each : application.secondary_devices.all()) {
    if (can) can = passes::check_texture_count(each->device(), scene);
  }
  return can;
}

}  // namespace

Session::Session(Application& application, Document& document)
    : application_(application),
      document_(document),
      load_(document.load()),
      options_(document.options()),
      window_(application.windows.empty() ? nullptr : application.windows.front().window.get()) {}

Result<std::unique_ptr<Session>> Session::open(Application& application, Document& document,
                                               const std::string& notice) {
  std::unique_ptr<Session> session(new Session(application, document));
  const Result<bool> loaded = session->wait_for_scene();
  if (!loaded) return loaded.error();
  if (!*loaded) return std::unique_ptr<Session>();
  if (Result<void> chosen = session->choose_camera(); !chosen) return chosen.error();
  if (Result<void> opened = session->open_links(notice); !opened) return opened.error();
  if (Result<void> uploaded = session->upload(); !uploaded) return uploaded.error();
  session->create_scene();
  session->watch_file();
  if (Result<void> applied = session->apply_overlay(); !applied) return applied.error();
  if (Result<void> created = session->create_views(); !created) return created.error();
  if (Result<void> created = session->create_loop(); !created) return created.error();
  return session;
}

Result<bool> Session::wait_for_scene() {
  Result<const scene::LoadedScene*> loaded = load_.wait([&] {
    if (!window_) return;
    sinks::Window::poll_events();
    if (window_->should_close()) document_.abandon();
  });
  if (!loaded && window_ && window_->should_close()) return false;
  if (!loaded) return loaded.error();
  loaded_ = *loaded;
  application_.note_start(load_.is_cached() ? "scene from the cache" : "scene");
  log_messages(load_.notes());
  log_scene_summary(document_.title(), scene());
  if (application_.view_state.draw.path) {
    for (const std::string& limit : passes::path_tracing_limits(scene())) log_message(warning(limit));
  }
  return true;
}

Result<void> Session::choose_camera() {
  using Animations = std::optional<Playing>;
  Result<Animations> animations =
      make_or_default<Animations>(application_, options_, &Options::animate,
                                  [&](const Options& options) { return open_animations(options, scene()); });
  if (!animations) return animations.error();
  if (*animations) animations_.emplace(std::move(**animations));
  overlay_file_ = overlay_file(options_, document_.has_own_file());
  Result<state::EditDocument> overlay = load_overlay(options_);
  if (!overlay) return overlay.error();
  overlay_ = std::move(*overlay);
  Result<CameraRig> camera =
      make_or_default<CameraRig>(application_, options_, &Options::camera, [&](const Options& options) {
        const std::string name = may_add_camera(overlay_, options.camera) ? std::string() : options.camera;
        return CameraRig::create(scene(), camera_start(view_defaults(options), scene(), name, playing()));
      });
  if (!camera) return camera.error();
  camera_.emplace(std::move(*camera));
  if (const std::string line = set_exposure(options_.draw.post, scene(), application_.view_state.draw);
      !line.empty())
    log_message("info: " + line);
  return {};
}

Result<void> Session::open_links(const std::string& notice) {
  poses_.emplace(scene());
  receiver_.emplace(*poses_, options_.lockstep, options_.play, application_.budgets);
  replies_.emplace(receiver_->images());
  requests_.emplace(*replies_, image_abilities(*application_.renderer, traces_requests(options_)));
  receiver_->images().set_handler(&*requests_);
  next_.emplace(document_, application_.caches,
                [this](const scene::Scene& other) { return can_show(application_, other); });
  if (!notice.empty()) next_->note(notice);
  Result<std::unique_ptr<Recording>> recording = open_recording(options_, document_);
  if (!recording) return recording.error();
  recording_ = std::move(*recording);
  if (Result<void> listening = open_listeners(options_, application_.is_first_document, application_.budgets,
                                              recording_.get(), *receiver_, *next_);
      !listening) {
    if (recording_) recording_->discard();
    return listening.error();
  }
  if (recording_) {  // a replay has no thread of its own
    receiver_->watch(
        [this, count = receiver_->links().size()](size_t listener, const transport::LinkEvent& event) {
          if (listener >= count) recording_->take(listener, event);
        });
  }
  if (std::unique_ptr<replay::ReplayLink> replayed = document_.take_replay()) {
    timeline_ = replayed.get();
    log_message("replaying " + timeline_->uri());
    receiver_->add(std::move(replayed));
  }
  if (application_.is_first_document) {  // one instance counts over all documents
    Result<std::unique_ptr<RendererMetrics>> metrics = open_metrics(options_, application_.budgets);
    if (!metrics) return metrics.error();
    application_.metrics = std::move(*metrics);
    Result<std::unique_ptr<serve::Server>> server = open_live_view(options_);
    if (!server) return server.error();
    application_.server = std::move(*server);
  }
  Result<std::unique_ptr<sinks::FileSink>> image_folder = open_image_folder(options_);
  if (!image_folder) return image_folder.error();
  image_folder_ = std::move(*image_folder);
  if (recording_) recording_end_.emplace([this] { return finish_recording(); });
  if (image_folder_) exit_tasks_.emplace_back([this] { return image_folder_->finish() ? 0 : 1; });
  exit_tasks_.emplace_back([this] { return application_.stats.finish() ? 0 : 1; });
  return {};
}

Result<void> Session::upload() {
  const Activity activity("uploading the scene");
  attached_.emplace(application_.windows);
  for (const OpenWindow& open : application_.windows) {
    if (Result<void> attached = open.window->attach(application_.instance, application_.device); !attached)
      return attached.error();
  }
  VkExtent2D extent{options_.width, options_.height};
  if (window_ && window_->framebuffer_extent().width != 0) extent = window_->framebuffer_extent();
  if (Result<void> uploaded = upload_scene(application_, *loaded_, extent); !uploaded)
    return uploaded.error();
  application_.renderer->apply(application_.view_state.draw);
  application_.secondary_devices.forget_scene();
  application_.note_start("scene on the device");
  return {};
}

void Session::create_scene() {
  ViewState& view_state = application_.view_state;
  std::vector<const gpu::Device*> secondary;
  for (const std::unique_ptr<SecondaryDevice>& each : application_.secondary_devices.all())
    secondary.push_back(&each->device());
  uploader_.emplace(*application_.renderer, std::move(secondary));
  live_.emplace(*loaded_, *poses_, *uploader_,
                AssetSettings{options_.assets, passes::levels_for(options_.draw.levels_of_detail),
                              uploader_->max_textures(), overlay_file_.path});
  camera_->set_edits(live_->edits());
  live_->on_scene_replaced(
      [this](const scene::Scene&, const scene::Scene& after) { camera_->set_scene(after); });
  editor_.emplace(view_state, overlay_file_, std::move(overlay_));
  if (document_.has_own_file())
    editor_->set_export({[this] { return document_.load().gltf_file(); }, options_.scene});
  editor_->set_shown_additions([this] { return std::span(live_->shown_additions()); },
                               [this] { return std::span(live_->added_materials()); });
  live_->on_scene_replaced([this, &view_state](const scene::Scene& before, const scene::Scene& after) {
    editor_->replace_scene(before, after, robot());
    live_->set_user_edits(view_state.edits);
    receiver_->set_scene(&after);
  });
  receiver_->set_scene(&scene());
  live_->set_shows_markers(options_.markers);
  if (animations_) live_->set_animations(animations_->player, animations_->chosen);
  if (!options_.variant.empty()) {
    if (Result<uint32_t> variant = scene::find_variant(scene(), options_.variant); variant)
      live_->set_loaded_variant(*variant);
  }
}

void Session::watch_file() {
  moves_robot_ = window_ || application_.server || !editor_->history().document().empty();
  if (options_.watch && document_.has_own_file()) {
    SceneReload::Hooks hooks;
    hooks.load = [this](std::function<bool()> stop) { return document_.load_again(std::move(stop)); };
    hooks.keep = [this](std::unique_ptr<SceneLoad> shown) { show_reloaded(std::move(shown)); };
    hooks.can_show = [this](const scene::Scene& other) { return can_show(application_, other); };
    hooks.animations = [this](const scene::Scene& other) { return animations_of_reloaded(options_, other); };
    reload_.emplace(load_, std::move(hooks));
  }
  load_.begin_caching();
}

void Session::show_reloaded(std::unique_ptr<SceneLoad> load) {
  if (const auto loaded = load->wait(); loaded)
    camera_->set_ground(camera_start(view_defaults(options_), (*loaded)->scene, {}, {}).ground);
  if (moves_robot_) {
    std::optional<state::RobotPose> next_robot = find_robot(*load);
    ViewState& view_state = application_.view_state;
    editor_->replace_robot(live_->scene(), robot(), next_robot ? &*next_robot : nullptr);
    robot_ = std::move(next_robot);
    if (robot_) (void)robot_->set(view_state.edits.joints);
    live_->set_user_edits(view_state.edits);
  }
  document_.keep(std::move(load));
}

Result<void> Session::apply_overlay() {
  ViewState& view_state = application_.view_state;
  if (moves_robot_) robot_ = find_robot(load_);
  editor_->begin({scene(), poses_->names(), robot()});
  editor_->offer_recovery(window_ != nullptr);
  live_->set_user_edits(view_state.edits);
  if (robot_) robot_->set(view_state.edits.joints);
  log_messages(editor_->take_log_messages());
  const bool has_additions = live_->await_additions([this] {
    if (window_) sinks::Window::poll_events();
    return stop_was_requested() || (window_ && window_->should_close());
  });
  editor_->report_start({live_->scene(), poses_->names(), robot(), live_->added_materials()});
  log_messages(live_->take_log_messages());
  log_messages(editor_->take_log_messages());
  // A stopped run ends with its frame loop, without the camera.
  if (has_additions && may_add_camera(editor_->history().document(), options_.camera)) {
    const Result<size_t> added = find_added_camera(options_.camera, live_->scene(), live_->shown_additions());
    if (!added) return added.error();
    camera_->select(*added);
  }
  return {};
}

Result<void> Session::create_views() {
  gpu::Device& device = application_.device;
  if (window_) {
    Result<std::unique_ptr<WindowView>> view = WindowView::create(
        {device, application_.renderer, *poses_, *receiver_, *requests_, *live_, *camera_,
         application_.windows, application_.view_state, *editor_, window_view_options(options_), playing(),
         robot_, application_.is_first_document});
    if (!view) return view.error();
    view_ = std::move(*view);
    exit_tasks_.emplace_back([this] {
      view_->finish();  // videos and screenshots
      return 0;
    });
  }
  if (!application_.server) return {};
  std::function<Result<void>(const settings::DrawSettings&)> replace_renderer;
  if (may_switch_renderer(options_, device))
    replace_renderer =
        renderer_switch({device, application_.renderer, application_.view_state, *requests_, *live_});
  live_view_.emplace(LiveView::Borrowed{*application_.server, *replies_, *receiver_, *poses_, *requests_,
                                        *live_, application_.view_state, robot_, *application_.renderer,
                                        std::move(replace_renderer)},
                     *camera_, std::filesystem::path(document_.title()).filename().string());
  return {};
}

Result<void> Session::create_loop() {
  sinks::FrameSink& sink = image_folder_ ? static_cast<sinks::FrameSink&>(*image_folder_) : no_files_;
  std::shared_ptr<const std::string> provenance;
  if (image_folder_ && !window_ && !application_.server) {  // else users change the view
    auto described =
        describe_live_run(options_, scene(), editor_->history().document(), application_.device.report());
    if (!described) return described.error();
    provenance = std::move(*described);
  }
  loop_.emplace(FrameLoopContext{.device = application_.device,
                                 .renderer = *application_.renderer,
                                 .poses = *poses_,
                                 .receiver = *receiver_,
                                 .requests = *requests_,
                                 .scene = *live_,
                                 .camera = *camera_,
                                 .sink = sink,
                                 .stats = application_.stats,
                                 .secondary_devices = application_.secondary_devices,
                                 .settings = application_.view_state.draw,
                                 .options = options_,
                                 .robot = robot_,
                                 .animations = animations_ ? &*animations_->player : nullptr,
                                 .window = view_.get(),
                                 .live_view = live_view_ ? &*live_view_ : nullptr,
                                 .metrics = application_.metrics.get(),
                                 .timeline = timeline_,
                                 .recording = recording_.get(),
                                 .next = &*next_,
                                 .reload = reload_ ? &*reload_ : nullptr,
                                 .provenance = std::move(provenance)});
  return loop_->open_checkpoint();
}

// Returns an exit code.
int Session::finish_recording() {
  receiver_->end_arrivals();
  log_message(recording_->finish());
  int exit_code = 0;
  for (const Error& fault : recording_->shortfalls()) exit_code = report_failure(fault);
  return exit_code;
}

Result<std::unique_ptr<Document>> Session::close(const Result<void>& looped) {
  if (view_) view_->record_unfinished_edits();
  log_messages(editor_->end((view_ && view_->should_close()) || loop_->switches_document()));
  if (recording_end_ && recording_end_->run() != 0) application_.exit_code = 1;
  if (const std::optional<Error> fault = load_.finish_caching()) log_cache_error(*fault);
  log_message(count_images(loop_->images(), options_, image_folder_.get()) + "\n" +
              application_.stats.summary());
  if (image_folder_) warn_of_stale_frames(options_, *image_folder_);
  if (!looped) return looped.error();
  return loop_->switches_document() ? next_->take() : nullptr;
}

}  // namespace fire3dv::app
