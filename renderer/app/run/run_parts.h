// Parts of a live run that its options open: windows, listeners, recording, metrics, live view and image
// folder; and what the run says of the folder at its end.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "base/error.h"
#include "base/peer_budget.h"
#include "renderer/app/document.h"
#include "renderer/app/options/options.h"
#include "renderer/app/recording.h"
#include "renderer/app/renderer_metrics.h"
#include "renderer/browser/server/server.h"
#include "renderer/gpu/device/device.h"
#include "renderer/sinks/file_sink.h"
#include "renderer/streams/stream_receiver.h"
#include "renderer/window/window_view.h"

namespace fire3dv::app {

// Prints the devices. Returns the exit code.
int list_devices(const gpu::Instance& instance);

// A cheap check, so that a wrong file name is reported rather than a missing display.
Result<void> check_scene_file(const Options& options);

// None with --headless.
Result<Windows> open_windows(const Options& options);

// Opens all listeners. insist: any failure is an error; otherwise failed listeners are reported, and the
// scene is shown without them.
Result<void> open_listeners(const Options& options, bool insist, const std::shared_ptr<BudgetPool>& budgets,
                            Recording* recording, StreamReceiver& receiver, DocumentLoader& notes);

// Null without the option; so are the next three.
Result<std::unique_ptr<Recording>> open_recording(const Options& options, const Document& document);

Result<std::unique_ptr<RendererMetrics>> open_metrics(const Options& options,
                                                      const std::shared_ptr<BudgetPool>& budgets);

// The links are secrets: they are printed once, for the user.
// Checks addresses, keys, certificates and names of files, before the slow steps of a start and before a
// display is needed. What is opened later may still fail.
Result<void> check_links_and_files(const Options& options);
Result<std::unique_ptr<serve::Server>> open_live_view(const Options& options);

Result<std::unique_ptr<sinks::FileSink>> open_image_folder(const Options& options);

// True if colours of requested images may be path-traced: no image of a window refines meanwhile.
bool traces_requests(const Options& options);

// True if viewers in browsers may switch between raster and paths.
bool may_switch_renderer(const Options& options, const gpu::Device& device);

WindowViewOptions window_view_options(const Options& options);

// Number of drawn images; with --out, of those that are complete in the folder.
std::string count_images(uint64_t drawn, const Options& options, sinks::FileSink* folder);

// Tools that read all files of a folder mix two runs.
void warn_of_stale_frames(const Options& options, const sinks::FileSink& folder);

}  // namespace fire3dv::app
