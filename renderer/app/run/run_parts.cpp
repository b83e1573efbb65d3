#include "renderer/app/run/run_parts.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

#include "base/files.h"
#include "base/log.h"
#include "base/plural.h"
#include "protocol/transport/core/secret.h"
#include "protocol/transport/open.h"
#include "protocol/transport/tcp/tcp_connection.h"
#include "renderer/app/start.h"
#include "renderer/browser/server/access.h"
#include "renderer/gpu/device/driver_files.h"
#include "renderer/passes/path/path_pass.h"
#include "renderer/scene/gltf/foreign_file.h"

namespace fire3dv::app {
namespace {

transport::http::AccessOptions access_options(const Options& options, const std::string& option) {
  return {options.sites, [option](const std::string& text) { log_message(warning(option + ": " + text)); }};
}

}  // namespace

int list_devices(const gpu::Instance& instance) {
  const std::vector<gpu::DeviceReport> reports = gpu::report_devices(instance.handle());
  if (reports.empty()) {
    return report_failure(Error{"no Vulkan device found: " +
                                gpu::driver_advice([](const char* name) { return std::getenv(name); })});
  }
  for (const gpu::DeviceReport& report : reports)
    std::printf("%s; %s\n", gpu::describe(report).c_str(), gpu::describe_identity(report).c_str());
  return 0;
}

Result<void> check_links_and_files(const Options& options) {
  const transport::TlsListenerOptions tls{options.tls_certificate, options.tls_key, options.tls_client_ca};
  for (const std::string& uri : options.listen) {
    if (Result<void> good = transport::check_uri(uri); !good)
      return Error{"--listen: " + good.error().message};
    if (!uri.starts_with("tls://")) continue;
    if (Result<transport::tcp::TlsContext> context = transport::tcp::make_server_context(uri, tls); !context)
      return context.error();
  }
  if (!options.key_file.empty()) {
    if (Result<transport::Secret> key = transport::read_key_file(options.key_file); !key)
      return Error{"--key-file: " + key.error().message};
  }
  if (!options.serve.empty() && !tls.certificate_file.empty()) {
    Result<transport::tcp::TlsContext> context =
        transport::tcp::make_server_context("--serve " + options.serve, tls);
    if (!context) return context.error();
  }
  if (!options.serve_tokens.empty()) {
    if (Result<serve::Tokens> tokens = serve::read_or_create_tokens(options.serve_tokens); !tokens)
      return tokens.error();
  }
  std::error_code ignored;
  std::filesystem::path there = options.out;  // as much of it as exists
  while (!there.empty() && there != there.parent_path() && !std::filesystem::exists(there, ignored))
    there = there.parent_path();
  if (!there.empty() && !std::filesystem::is_directory(there, ignored)) {
    if (Result<void> made = base::create_folder(options.out); !made)
      return Error{"--out: " + made.error().message};
  }
  const std::filesystem::path record_folder = std::filesystem::path(options.recording.record).parent_path();
  if (!record_folder.empty() && !std::filesystem::is_directory(record_folder, ignored))
    return Error{"--record: the folder " + record_folder.string() + " does not exist; create it"};
  if (!options.environment.empty() && !std::filesystem::exists(options.environment, ignored))
    return load_environment(options.environment).error();
  return {};
}

Result<void> open_listeners(const Options& options, bool insist, const std::shared_ptr<BudgetPool>& budgets,
                            Recording* recording, StreamReceiver& receiver, DocumentLoader& notes) {
  size_t number = 0;
  for (const std::string& uri : options.listen) {
    transport::ListenerOptions listener_options;
    listener_options.delivery = options.lockstep ? transport::Delivery::all : transport::Delivery::newest;
    if (recording)
      listener_options.on_arrival = [recording, listener = number++](const transport::LinkEvent& event) {
        recording->take(listener, event);
      };
    listener_options.insecure = options.insecure;
    listener_options.budgets = budgets;
    listener_options.key_file = options.key_file;
    listener_options.tls = {options.tls_certificate, options.tls_key, options.tls_client_ca};
    Result<std::unique_ptr<transport::ListenerLink>> listener =
        transport::open_listener(uri, listener_options);
    if (!listener && !insist) {
      notes.note(listener.error().message + "; no simulator can connect there now");
      continue;
    }
    if (!listener) return listener.error();
    log_message("listening on " + (*listener)->uri());
    receiver.add(std::move(*listener));
  }
  return {};
}

Result<std::unique_ptr<Recording>> open_recording(const Options& options, const Document& document) {
  if (options.recording.record.empty()) return std::unique_ptr<Recording>();
  return Recording::open(options.recording, document.scene_attachment());
}

Result<std::unique_ptr<RendererMetrics>> open_metrics(const Options& options,
                                                      const std::shared_ptr<BudgetPool>& budgets) {
  if (options.metrics.empty()) return std::unique_ptr<RendererMetrics>();
  Result<std::unique_ptr<RendererMetrics>> opened =
      RendererMetrics::open(options.metrics, options.insecure, budgets, access_options(options, "--metrics"));
  if (opened) log_message("metrics at http://" + (*opened)->address() + "/metrics");
  return opened;
}

Result<std::unique_ptr<serve::Server>> open_live_view(const Options& options) {
  if (options.serve.empty()) return std::unique_ptr<serve::Server>();
  serve::ServerOptions server_options;
  server_options.at = options.serve;
  server_options.insecure = options.insecure;
  server_options.tls = {options.tls_certificate, options.tls_key, options.tls_client_ca};
  server_options.token_file = options.serve_tokens;
  server_options.access = access_options(options, "--serve");
  Result<std::unique_ptr<serve::Server>> opened = serve::Server::open(server_options);
  if (!opened) return opened;
  log_message("live view; whoever has a link has its rights:");
  std::fprintf(stderr, "  control  %s\n  view     %s\n", (*opened)->link(serve::Access::control).c_str(),
               (*opened)->link(serve::Access::view).c_str());
  return opened;
}

Result<std::unique_ptr<sinks::FileSink>> open_image_folder(const Options& options) {
  if (options.out.empty()) return std::unique_ptr<sinks::FileSink>();
  sinks::FileSinkOptions file_options;
  file_options.folder = options.out;
  return sinks::FileSink::open(file_options);
}

bool traces_requests(const Options& options) {
  return options.on_request || (options.headless && !options.serve.empty());
}

bool may_switch_renderer(const Options& options, const gpu::Device& device) {
  const bool draws_for_viewers = options.on_request || (options.frames == 0 && options.out.empty() &&
                                                        options.stats.empty() && !options.lockstep);
  const bool needs_one_kind = options.outputs != passes::ImageOutputs() || !options.devices.empty();
  return options.headless && draws_for_viewers && !needs_one_kind && passes::can_trace_paths(device).ok();
}

WindowViewOptions window_view_options(const Options& options) {
  const std::string& replay = options.recording.replay;
  return {.has_panels = options.panels,
          .has_light_panels = options.light_panels,
          .right_camera = options.right_camera,
          .view = view_defaults(options),
          .size = {options.width, options.height},
          .screenshots = options.screenshots,
          .screenshot_size = options.screenshot_size,
          .file = replay.empty() ? options.scene.string() : replay,
          .stale_overlay = options.play.mark_held,
          .writes_images = !options.out.empty(),
          .has_outputs = options.outputs != passes::ImageOutputs(),
          .has_secondary_devices = !options.devices.empty(),
          .has_live_view = !options.serve.empty(),
          .is_lockstep = options.lockstep};
}

std::string count_images(uint64_t drawn, const Options& options, sinks::FileSink* folder) {
  if (!folder) return counted(drawn, "image");
  (void)folder->finish().ok();  // for the count; the loop returns the error
  const uint64_t written = folder->frames_written();
  return counted(written, "image") + " in " + options.out.string() +
         (written < drawn
              ? "; " + std::to_string(drawn - written) + " of " + counted(drawn, "image") + " missing"
              : "");
}

void warn_of_stale_frames(const Options& options, const sinks::FileSink& folder) {
  if (const uint64_t stale = folder.count_stale_frames(); stale != 0)
    log_message(warning(
        options.out.string() + " has " + counted(stale, "frame") +
        " of an earlier run beyond the last one of this run; they stay: remove them, or use frames.jsonl"));
}

Result<void> check_scene_file(const Options& options) {
  if (options.scene.empty() || options.list_devices) return {};
  if (!needs_conversion(options.scene)) return scene::check_is_gltf(options.scene);
  std::error_code error;
  if (std::filesystem::is_directory(options.scene, error)) return {};  // a model folder of Gazebo
  if (Result<OpenFile> file = OpenFile::open(options.scene, UINT64_MAX); !file)
    return Error{options.scene.string() + ": " + file.error().message};
  return {};
}

Result<Windows> open_windows(const Options& options) {
  Windows windows;
  if (options.headless || options.list_devices) return windows;
  do {
    const bool named = options.window_cameras.size() > 1;
    Result<std::unique_ptr<sinks::Window>> opened = sinks::Window::open(
        "FIRE-3DV" + (named ? " " + options.window_cameras[windows.size()] : std::string()),
        {options.width, options.height}, options.present);
    if (!opened) return opened.error();
    const size_t number = windows.size();
    windows.push_back({std::move(*opened), named ? options.window_cameras[number] : std::string()});
  } while (windows.size() < options.window_cameras.size());
  return windows;
}

}  // namespace fire3dv::app
