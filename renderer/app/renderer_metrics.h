// Prometheus metrics of the renderer (--metrics): links, streams, images, passes, memory. The frame loop
// publishes a snapshot a few times a second without blocking; the server thread formats it.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "renderer/app/frame_stats.h"
#include "renderer/browser/server/server.h"
#include "renderer/metrics/metric_families.h"
#include "renderer/metrics/metrics_server.h"
#include "renderer/state/edits/edit_registry.h"
#include "renderer/streams/stream_receiver.h"

namespace fire3dv::app {

// Viewers of the live view, and the images that were encoded for them.
struct BrowserNumbers {
  uint64_t control = 0, view = 0;  // by their rights
  serve::EncodeTotals jpeg, h264, vp8;
};

class RendererMetrics {
 public:
  // at: "HOST:PORT".
  static Result<std::unique_ptr<RendererMetrics>> open(const std::string& at, bool insecure,
                                                       std::shared_ptr<const BudgetPool> budgets,
                                                       const transport::http::AccessOptions& access);
  std::string address() const { return server_->address(); }

  // --- frame loop thread ---
  // Counts a submitted image that displays these frames.
  void drawn(const std::vector<state::FrameTag>& shown, const StreamReceiver& receiver,
             const FrameCost& cost);
  void add(const gpu::FrameTimes& times);
  // Call once per image: publishes a snapshot if the interval has elapsed.
  void tell(const StreamReceiver& receiver, size_t open_image_requests, const state::PoseState& poses,
            const state::EditFaults& faults, const BrowserNumbers& viewers);

 private:
  struct Drawn {
    uint64_t epoch = 0;
    uint64_t sequence = 0;  // newest displayed sequence
    uint64_t frames = 0;
    int64_t published_ns = 0;
    bool has_publish_time = false;
    metrics::Histogram latency;
  };
  struct StreamNumbers {
    StreamReceiver::Report report;
    Drawn drawn;
    std::string name;
    state::Condition condition{};
    uint64_t nodes = 0, unmatched = 0, conflicting = 0;
    uint64_t received = 0, incomplete = 0, stale = 0, refused = 0, baseless = 0, held = 0, overtaken = 0;
    uint64_t edits_received = 0, edits_stale = 0, edits_refused = 0;
    PeerBudget::DrawCost draw_cost;
  };
  struct PassNumbers {
    bool is_async = false;
    uint64_t count = 0;
    double sum_s = 0;
  };
  struct Numbers {
    int64_t taken_ns = 0;
    uint64_t images = 0;
    metrics::Histogram interval, cpu, gpu;
    std::map<std::string, PassNumbers> passes;
    std::vector<StreamReceiver::LinkReport> links;
    std::array<uint64_t, kRefusalCount> refusals{};
    std::vector<StreamNumbers> streams;
    state::EditFaults edit_faults;
    uint64_t image_requests = 0, image_requests_refused = 0;
    BrowserNumbers viewers;
    std::vector<metrics::PeerUse> peers;
  };
  RendererMetrics() = default;
  void write_page(metrics::Exposition& page) const;  // server thread
  static void write_viewers(metrics::Exposition& page, const BrowserNumbers& viewers);
  static void write_images(metrics::Exposition& page, const Numbers& numbers);
  static void write_links(metrics::Exposition& page, const Numbers& numbers);
  static void write_streams(metrics::Exposition& page, const Numbers& numbers, int64_t now_ns);
  static void write_edits(metrics::Exposition& page, const Numbers& numbers);

  std::vector<metrics::PeerUse> peer_uses(const StreamReceiver& receiver) const;

  std::shared_ptr<const BudgetPool> budgets_;
  // Used on the frame loop thread only.
  Numbers gathered_;
  std::map<uint64_t, Drawn> drawn_of_epoch_;
  int64_t next_ns_ = 0;

  mutable std::mutex mutex_;  // guards pointer copies only
  std::shared_ptr<const Numbers> published_;
  std::unique_ptr<metrics::MetricsServer> server_;  // last: its thread ends before its data
};

}  // namespace fire3dv::app
