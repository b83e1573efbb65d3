// Render server of Drake's glTF render client.

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <string>
#include <variant>

#include "base/log.h"
#include "base/plural.h"
#include "base/process/stop_signals.h"
#include "programs/drake/options.h"
#include "programs/drake/render/request_pipeline.h"
#include "renderer/app/start.h"
#include "renderer/gpu/selection/required_gpu.h"
#include "renderer/loading/disk_caches.h"
#include "renderer/scene/textures/environment.h"

namespace fire3dv::drake {
namespace {

// A stop does not wait longer for an image that is being rendered.
constexpr std::chrono::milliseconds kStopPatience{300};

void log(const std::string& text) {
  print_log_line("fire3dv-drake", text);
}

int fail(const Error& error) {
  log(error_line(error.message));
  return 1;
}

int run(const Options& options) {
  if (options.drawing.require_gpu) {
    if (Result<void> found = gpu::check_required_gpu(options.drawing.device); !found) {
      fail(found.error());
      return gpu::kNoGpuExitStatus;
    }
  }
  Result<std::shared_ptr<const scene::EnvironmentImage>> environment =
      app::load_environment(options.drawing.environment);
  if (!environment) return fail(environment.error());
  gpu::InstanceOptions instance_options;
  instance_options.validation = options.drawing.validation;
  Result<std::unique_ptr<gpu::Instance>> instance = gpu::Instance::create(instance_options);
  if (!instance) return fail(instance.error());
  int exit_code = 0;
  {
    Result<std::unique_ptr<gpu::Device>> device = app::open_device(**instance, options.drawing);
    if (!device) return fail(device.error());
    const app::CacheLocations cache_locations =
        app::find_cache_locations(options.drawing.cache, [](const char* name) { return std::getenv(name); });
    app::PipelineCacheFile pipelines(**device, cache_locations.pipelines);
    if (pipelines.note()) log(warning(*pipelines.note()));
    for (const std::string& unused : app::settings_without_effect(**device, options.drawing))
      log(warning(unused));
    settings::DrawSettings settings = options.drawing.draw;
    settings.environment = std::move(*environment);
    settings.cached_environments = app::environment_store(cache_locations.environments);

    std::atomic<bool> stopping = false;
    ImageRenderer renderer(**device, options.drawing, settings, options.render,
                           [&stopping] { return stopping.load(); });
    std::unique_ptr<RequestPipeline> pipeline;
    Result<std::unique_ptr<HttpServer>> server =
        HttpServer::open(options.address, options.drawing.insecure, options.http,
                         [&](HttpRequest&& request, HttpServer::Answer answer) {
                           pipeline->push(std::move(request), std::move(answer));
                         },
                         {options.sites, [](const std::string& text) { log(warning(text)); }});
    if (!server) return fail(server.error());
    pipeline = std::make_unique<RequestPipeline>(renderer, [&](const std::string& failure) {
      exit_code = fail(Error{failure});
      (*server)->stop();
    });
    log("serving Drake on http://" + (*server)->address() + "/render");
    (*server)->run([&stopping] { stopping = true; });
    if (!pipeline->stop(kStopPatience)) std::_Exit(exit_code);  // nothing is left to be written
    pipeline.reset();
    if (Result<void> stored = pipelines.keep(); !stored) app::log_cache_error(stored.error());
  }
  if (const uint64_t messages = (*instance)->validation_messages())
    exit_code = fail(Error{counted(messages, "validation message")});
  return exit_code;
}

}  // namespace
}  // namespace fire3dv::drake

int main(int argc, char** argv) {
  using namespace fire3dv;
  const std::variant<drake::Options, int> options = drake::parse_options(argc, argv);
  if (const int* exit_code = std::get_if<int>(&options)) return *exit_code;
  ignore_write_signals();
  try {
    return drake::run(std::get<drake::Options>(options));
  } catch (const std::exception& failure) {  // Vulkan errors and out of memory: not recoverable
    std::fprintf(stderr, "fire3dv-drake: error: %s\n", failure.what());
    return 1;
  }
}
