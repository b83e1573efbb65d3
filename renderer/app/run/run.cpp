#include <chrono>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "base/log.h"
#include "base/plural.h"
#include "base/process/failure.h"
#include "renderer/app/document.h"
#include "renderer/app/options/overlay_options.h"
#include "renderer/app/run/application.h"
#include "renderer/app/run/run_parts.h"
#include "renderer/app/run/session.h"
#include "renderer/app/start.h"
#include "renderer/editing/view_transfer.h"
#include "renderer/gpu/selection/required_gpu.h"
#include "renderer/passes/path/path_pass.h"

namespace fire3dv::app {
namespace {

// Shows the document until its session ends. Returns the next document that the user opened, or null.
// previous: is destroyed once the document is displayed. notice: shown to the user.
Result<std::unique_ptr<Document>> run_session(Application& application, Document& document,
                                              std::unique_ptr<Document>& previous,
                                              const std::string& notice) {
  Result<std::unique_ptr<Session>> session = Session::open(application, document, notice);
  if (!session) return session.error();
  if (!*session) return std::unique_ptr<Document>();
  previous.reset();
  const Result<void> looped = (*session)->loop();
  return (*session)->close(looped);
}

// Shows the document, and those that the user opens. After an error the previous document is shown again.
// Returns the exit code.
int run_documents(Application& application, std::unique_ptr<Document> document) {
  std::unique_ptr<Document> previous;
  std::string next_notice;
  while (document) {
    const std::string notice = std::exchange(next_notice, {});
    Result<std::unique_ptr<Document>> next = run_session(application, *document, previous, notice);
    if (next) {
      previous = std::exchange(document, std::move(*next));
    } else if (previous) {
      next_notice = next.error().message + "; the previous scene is shown again";
      document = std::move(previous);
      if (Result<void> restarted = document->restart_epoch(); !restarted)
        next_notice += ", but " + restarted.error().message;
    } else {
      if (!notice.empty()) log_message(error_line(notice));
      application.exit_code = report_failure(document->with_scene_name(next.error()));
      document.reset();
    }
    application.is_first_document = false;
    forget_scene(application.view_state);
  }
  return application.exit_code;
}

}  // namespace

int run(const Options& options) {
  const Activity activity("starting");
  if (options.require_gpu) {
    if (Result<void> found = gpu::check_required_gpu(options.device, options.devices); !found) {
      report_failure(found.error());
      return gpu::kNoGpuExitStatus;
    }
  }
  if (Result<void> good = check_scene_file(options); !good) return report_failure(good.error());
  if (Result<state::EditDocument> overlay = load_overlay(options); !overlay)
    return report_failure(overlay.error());
  if (Result<void> good = check_links_and_files(options); !good) return report_failure(good.error());
  Result<FrameStats> stats = FrameStats::create(options.stats);
  if (!stats) return report_failure(stats.error());
  // Opens the scene before all slow steps.
  const CacheLocations caches =
      find_cache_locations(options.cache, [](const char* name) { return std::getenv(name); });
  std::unique_ptr<Document> document;
  if (!options.list_devices) {
    Result<std::unique_ptr<Document>> opened = Document::open(options, caches);
    if (!opened) return report_failure(opened.error());
    document = std::move(*opened);
  }
  // The window determines the required Vulkan extensions.
  Result<Windows> windows = open_windows(options);
  if (!windows) return report_failure(windows.error());
  gpu::InstanceOptions instance_options;
  instance_options.validation = options.validation;
  if (!windows->empty()) instance_options.window_extensions = windows->front().window->instance_extensions();
  Result<std::unique_ptr<gpu::Instance>> instance = gpu::Instance::create(instance_options);
  if (document && document->load().has_failed())
    return report_failure(document->with_scene_name(document->load().wait().error()));
  if (!instance) return report_failure(instance.error());
  if (options.list_devices) return list_devices(**instance);

  int exit_code = 0;
  {
    Result<std::shared_ptr<const scene::EnvironmentImage>> environment =
        load_environment(options.environment);
    if (!environment) return report_failure(environment.error());

    // The scene loads while the device opens and pipelines compile.
    Result<OpenDevices> devices = open_devices(**instance, options);
    if (document->load().has_failed())
      return report_failure(document->with_scene_name(document->load().wait().error()));
    if (!devices) return report_failure(devices.error());
    gpu::Device& device = *devices->first;
    if (options.draw.path) {
      if (Result<void> can = passes::can_trace_paths(device); !can)
        return report_failure(Error{"--render path: " + can.error().message});
    }
    for (const std::string& unused : settings_without_effect(device, options)) log_message(warning(unused));
    PipelineCacheFile pipelines(device, caches.pipelines);
    if (pipelines.note()) log_message(warning(*pipelines.note()));
    ViewState view_state;
    view_state.draw = options.draw;
    view_state.draw.environment = std::move(*environment);
    view_state.paths = options.draw.path.value_or(settings::PathSettings());
    view_state.paths.lens = options.draw.post.lens;
    view_state.draw.cached_environments = environment_store(caches.environments);
    std::optional<passes::SceneRenderer> renderer(std::in_place, device, view_state.draw);
    Result<SecondaryDevices> secondary_devices = SecondaryDevices::open(
        **instance, devices->secondary, options.async_compute, caches, view_state.draw, *renderer);
    if (!secondary_devices) return report_failure(secondary_devices.error());
    Application application{.instance = **instance,
                            .device = device,
                            .renderer = renderer,
                            .stats = *stats,
                            .caches = caches,
                            .windows = *windows,
                            .view_state = view_state,
                            .secondary_devices = *secondary_devices,
                            .budgets = BudgetPool::create(options.peer_limits),
                            .begun = options.begun};
    application.note_start("renderer");
    if (Result<void> can = renderer->can_take(passes::with_sources(options.outputs)); !can)
      return report_failure(Error{"--outputs: " + can.error().message});
    if (Result<void> can = renderer->can_show(options.debug_view); !can)
      return report_failure(Error{"--view: " + can.error().message});
    if (!options.draw.post.lens.is_pinhole() && !options.draw.path) {
      if (Result<void> can = renderer->can_blur(); !can)
        return report_failure(Error{"--f-number: " + can.error().message});
    }
    view_state.debug_view = options.debug_view;
    exit_code = run_documents(application, std::move(document));
    if (Result<void> stored = pipelines.keep(); !stored) log_cache_error(stored.error());
  }
  if (const uint64_t messages = (*instance)->validation_messages()) {
    exit_code = report_failure(Error{counted(messages, "validation message")});
  }
  return exit_code;
}

}  // namespace fire3dv::app
