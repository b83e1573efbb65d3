// Parts of a live run that persist when the user opens another document.
#pragma once

#include <chrono>
#include <memory>
#include <optional>

#include "base/peer_budget.h"
#include "renderer/app/frame_stats.h"
#include "renderer/app/renderer_metrics.h"
#include "renderer/browser/server/server.h"
#include "renderer/editing/view_state.h"
#include "renderer/gpu/device/device.h"
#include "renderer/images/secondary_devices.h"
#include "renderer/loading/disk_caches.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/window/window_view.h"

namespace fire3dv::app {

struct Application {
  gpu::Instance& instance;
  gpu::Device& device;
  std::optional<passes::SceneRenderer>& renderer;  // never empty
  FrameStats& stats;
  const CacheLocations& caches;
  Windows& windows;
  ViewState& view_state;
  SecondaryDevices& secondary_devices;
  const std::shared_ptr<BudgetPool> budgets;  // of all adapters
  const std::chrono::steady_clock::time_point begun;
  std::unique_ptr<RendererMetrics> metrics = nullptr;  // null: no metrics
  std::unique_ptr<serve::Server> server = nullptr;     // null: no live view
  bool is_first_document = true;
  int exit_code = 0;  // 1 after an error that did not end the run

  // Notes the time from program start to a start-up milestone of the first document.
  void note_start(const char* milestone) const {
    if (!is_first_document) return;
    const auto since = std::chrono::steady_clock::now() - begun;
    stats.note_start(milestone, std::chrono::duration<double, std::milli>(since).count());
  }
};

}  // namespace fire3dv::app
