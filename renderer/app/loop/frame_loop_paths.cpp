// Path-traced images of the frame loop: samples of each image of a window, progress and checkpoints of
// others.
#include <chrono>
#include <string>
#include <utility>

#include "base/digest.h"
#include "base/log.h"
#include "renderer/app/loop/frame_loop.h"
#include "renderer/app/stop_signals.h"
#include "renderer/passes/path/path_pass.h"

namespace fire3dv::app {
namespace {

constexpr auto kRefineTime = std::chrono::milliseconds(20);  // for each image of a window

}  // namespace

// A replay's poses follow the clock: its images have no second run.
Result<void> FrameLoop::open_checkpoint() {
  const bool are_kept = !context_.window && context_.renderer.traces_paths() && wants_pixels() &&
                        context_.options.recording.replay.empty() &&
                        context_.options.checkpoint_interval_s > 0;
  if (!are_kept) return {};
  std::string environment;
  if (!context_.options.environment.empty()) {
    const Result<Digest> digest = digest_of_file(context_.options.environment, UINT64_MAX);
    if (!digest) return digest.error();
    environment = hex(*digest);
  }
  std::string run = context_.options.variant;
  if (!context_.options.overlay.empty()) {
    const Result<Digest> digest = digest_of_file(context_.options.overlay, UINT64_MAX);
    if (!digest) return digest.error();
    run += '\n' + hex(*digest);
  }
  checkpoint_.emplace(context_.options.out, context_.options, context_.device.report(),
                      std::move(environment), std::move(run));
  return {};
}

// A window goes on with other work between samples; without one, an image is whole.
passes::PathHooks FrameLoop::path_hooks(const passes::View& view, Progress& progress) {
  passes::PathHooks hooks{.should_stop = stop_was_requested};
  if (!context_.renderer.traces_paths()) return hooks;
  if (context_.window) {
    hooks.budget = kRefineTime;
    return hooks;
  }
  hooks.progress = [&progress, samples = context_.renderer.path_tracer()->settings().samples_per_pixel](
                       uint64_t done, uint64_t total) {
    progress.update_with_end(done * samples / total, samples);
  };
  if (checkpoint_)
    checkpoint_->attach(
        {images_, frame_extent_, context_.poses, view, context_.scene.scene(), context_.scene.replaced()},
        hooks);
  return hooks;
}

void FrameLoop::report_stopped_paths() const {
  if (checkpoint_)
    print_log_line("fire3dv", "stopped after " +
                                  std::to_string(context_.renderer.path_tracer()->progress().samples) +
                                  " samples per pixel; the same command goes on from here");
}

bool FrameLoop::refines() const {
  return context_.window && context_.renderer.traces_paths() &&
         !context_.renderer.path_tracer()->progress().is_whole();
}

}  // namespace fire3dv::app
