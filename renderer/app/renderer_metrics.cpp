#include "renderer/app/renderer_metrics.h"

#include <utility>

#include "base/clock.h"

namespace fire3dv::app {
namespace {

constexpr int64_t kPublishEveryNs = 100 * kMillisecondNs;

const char* name_of(state::Condition condition) {
  switch (condition) {
    case state::Condition::live:
      return "live";
    case state::Condition::late:
      return "late";
    case state::Condition::lost:
      return "lost";
  }
  return "";
}

const char* name_of(state::ClockOffset::Source source) {
  switch (source) {
    case state::ClockOffset::Source::none:
      return "none";
    case state::ClockOffset::Source::one_way:
      return "one_way";
    case state::ClockOffset::Source::round_trip:
      return "round_trip";
    case state::ClockOffset::Source::same_clock:
      return "same_clock";
  }
  return "";
}

}  // namespace

Result<std::unique_ptr<RendererMetrics>> RendererMetrics::open(const std::string& at, bool insecure,
                                                               std::shared_ptr<const BudgetPool> budgets,
                                                               const transport::http::AccessOptions& access) {
  std::unique_ptr<RendererMetrics> self(new RendererMetrics);
  self->budgets_ = std::move(budgets);
  auto server = metrics::MetricsServer::open(
      at, insecure, [raw = self.get()](metrics::Exposition& page) { raw->write_page(page); }, access);
  if (!server) return server.error();
  self->server_ = std::move(*server);
  return self;
}

void RendererMetrics::drawn(const std::vector<state::FrameTag>& shown, const StreamReceiver& receiver,
                            const FrameCost& cost) {
  const int64_t now_ns = monotonic_ns();
  if (gathered_.images > 0) gathered_.interval.add(cost.frame_ms * 1e-3);
  gathered_.cpu.add(cost.cpu_ms * 1e-3);
  ++gathered_.images;
  for (const state::FrameTag& tag : shown) {
    Drawn& drawn = drawn_of_epoch_[tag.epoch];
    if (std::exchange(drawn.sequence, tag.sequence) == tag.sequence) continue;  // frame already counted
    drawn.epoch = tag.epoch;
    ++drawn.frames;
    const std::optional<int64_t> published_ns = receiver.published_ns(tag.epoch, tag.publish_time_ns);
    drawn.has_publish_time = published_ns.has_value();
    if (!published_ns) continue;
    drawn.published_ns = *published_ns;
    drawn.latency.add(static_cast<double>(now_ns - *published_ns) * 1e-9);
  }
}

void RendererMetrics::add(const gpu::FrameTimes& times) {
  gathered_.gpu.add(times.total_ms * 1e-3);
  for (const gpu::PassTime& time : times.passes) {
    PassNumbers& pass = gathered_.passes[time.name];
    pass.is_async = time.async_compute;
    ++pass.count;
    pass.sum_s += time.milliseconds * 1e-3;
  }
}

void RendererMetrics::tell(const StreamReceiver& receiver, size_t open_image_requests,
                           const state::PoseState& poses, const state::EditFaults& faults,
                           const BrowserNumbers& viewers) {
  const int64_t now_ns = monotonic_ns();
  if (now_ns < next_ns_) return;
  next_ns_ = now_ns + kPublishEveryNs;
  gathered_.taken_ns = now_ns;
  gathered_.links = receiver.links();
  gathered_.refusals = receiver.refusals();
  gathered_.edit_faults = faults;
  gathered_.viewers = viewers;
  gathered_.image_requests = open_image_requests;
  gathered_.image_requests_refused = receiver.images().refused();
  gathered_.peers = peer_uses(receiver);
  gathered_.streams.clear();
  std::map<uint64_t, Drawn> still_there;  // drops the counts of ended streams
  for (StreamReceiver::Report& report : receiver.report()) {
    const state::Stream& stream = poses.streams()[report.id];
    StreamNumbers numbers;
    numbers.drawn = still_there[stream.epoch] = drawn_of_epoch_[stream.epoch];
    numbers.name = stream.name;
    numbers.condition = stream.condition;
    numbers.nodes = stream.scene_node_of_pose.size();
    numbers.unmatched = stream.unmatched_names.size();
    numbers.conflicting = stream.conflicting_names.size();
    numbers.received = stream.frames_received;
    numbers.incomplete = stream.frames_incomplete;
    numbers.stale = stream.frames_stale;
    numbers.refused = stream.frames_refused;
    numbers.baseless = stream.frames_without_base;
    numbers.held = stream.frames_queued;
    numbers.overtaken = stream.frames_superseded + report.overtaken;
    numbers.edits_received = stream.edits_received;
    numbers.edits_stale = stream.edits_stale;
    numbers.edits_refused = stream.edits_refused;
    if (report.budget) numbers.draw_cost = report.budget->draw_cost();
    numbers.report = std::move(report);
    gathered_.streams.push_back(std::move(numbers));
  }
  drawn_of_epoch_.swap(still_there);
  auto numbers = std::make_shared<const Numbers>(gathered_);
  const std::lock_guard lock(mutex_);
  published_.swap(numbers);
}

std::vector<metrics::PeerUse> RendererMetrics::peer_uses(const StreamReceiver& receiver) const {
  std::map<const PeerBudget*, state::StreamId> streams;
  for (const StreamReceiver::Report& report : receiver.report()) streams[report.budget.get()] = report.id;
  std::vector<metrics::PeerUse> uses;
  for (BudgetPool::Report& report : budgets_->report()) {
    const auto stream = streams.find(report.peer);
    uses.push_back({std::move(report.name), stream == streams.end() ? "" : std::to_string(stream->second),
                    report.used, report.refused});
  }
  return uses;
}

// --- server thread ---

void RendererMetrics::write_page(metrics::Exposition& page) const {
  std::shared_ptr<const Numbers> numbers;
  {
    const std::lock_guard lock(mutex_);
    numbers = published_;
  }
  page.family("fire3dv_build_info", "gauge", "The program's version.");
  page.sample({{"version", FIRE3DV_VERSION}}, uint64_t{1});
  metrics::write_process_use(page);
  if (!numbers) return;  // no image yet
  const int64_t now_ns = monotonic_ns();
  page.family("fire3dv_snapshot_age_seconds", "gauge",
              "How old the numbers on this page are: large when the renderer stands still.");
  page.sample({}, static_cast<double>(now_ns - numbers->taken_ns) * 1e-9);
  write_images(page, *numbers);
  write_viewers(page, numbers->viewers);
  write_links(page, *numbers);
  write_streams(page, *numbers, now_ns);
  write_edits(page, *numbers);
  metrics::write_peer_use(page, budgets_->limits(), numbers->peers);
}

void RendererMetrics::write_viewers(metrics::Exposition& page, const BrowserNumbers& viewers) {
  page.family("fire3dv_viewers", "gauge", "Viewers of the live view that are connected, by their rights.");
  page.sample({{"access", "control"}}, viewers.control);
  page.sample({{"access", "view"}}, viewers.view);
  const std::pair<const char*, const serve::EncodeTotals*> codecs[] = {
      {"jpeg", &viewers.jpeg}, {"h264", &viewers.h264}, {"vp8", &viewers.vp8}};
  page.family("fire3dv_viewer_encode_seconds", "summary", "Spent on encoding an image for a viewer.");
  for (const auto& [codec, totals] : codecs)
    page.summary({{"codec", codec}}, totals->images, totals->seconds);
  page.family("fire3dv_viewer_image_bytes_total", "counter", "Bytes of these images.");
  for (const auto& [codec, totals] : codecs) page.sample({{"codec", codec}}, totals->bytes);
}

void RendererMetrics::write_images(metrics::Exposition& page, const Numbers& numbers) {
  page.family("fire3dv_images_total", "counter", "Images drawn.");
  page.sample({}, numbers.images);
  page.family("fire3dv_image_interval_seconds", "histogram", "From one image to the next.");
  page.histogram({}, numbers.interval);
  page.family("fire3dv_image_cpu_seconds", "histogram", "Spent on recording and submitting an image.");
  page.histogram({}, numbers.cpu);
  page.family("fire3dv_image_gpu_seconds", "histogram", "From the first pass of an image to its last.");
  page.histogram({}, numbers.gpu);
  page.family("fire3dv_image_requests", "gauge", "Requests of simulators for images that are open.");
  page.sample({}, numbers.image_requests);
  page.family("fire3dv_image_requests_refused_total", "counter", "Of them, refused.");
  page.sample({}, numbers.image_requests_refused);
  page.family("fire3dv_pass_gpu_seconds", "summary",
              "Spent on each pass; passes on the side queue run beside others.");
  for (const auto& [name, pass] : numbers.passes)
    page.summary({{"pass", name}, {"queue", pass.is_async ? "side" : "main"}}, pass.count, pass.sum_s);
}

void RendererMetrics::write_links(metrics::Exposition& page, const Numbers& numbers) {
  const auto each = [&](const char* name, const char* type, const char* help, auto value) {
    page.family(name, type, help);
    for (const StreamReceiver::LinkReport& link : numbers.links)
      page.sample({{"listener", link.uri}}, uint64_t{value(link.stats)});
  };
  using Stats = transport::LinkStats;
  each("fire3dv_listener_peers", "gauge", "Publishers that are connected.",
       [](const Stats& stats) { return stats.peers; });
  each("fire3dv_listener_messages_received_total", "counter", "Whole messages that came.",
       [](const Stats& stats) { return stats.messages_received; });
  each("fire3dv_listener_bytes_received_total", "counter", "Bytes that came, of whomever.",
       [](const Stats& stats) { return stats.bytes_received; });
  each("fire3dv_listener_bytes_sent_total", "counter", "Bytes of replies.",
       [](const Stats& stats) { return stats.bytes_sent; });
  each("fire3dv_listener_poses_dropped_total", "counter",
       "Pose messages that a newer one replaced before they were processed.",
       [](const Stats& stats) { return stats.poses_dropped; });
  each("fire3dv_listener_images_sent_total", "counter", "Images sent back to their requesters.",
       [](const Stats& stats) { return stats.images_sent; });
  each("fire3dv_listener_images_dropped_total", "counter",
       "Images that a newer one of their request replaced, or that had no room.",
       [](const Stats& stats) { return stats.images_dropped; });
  page.family("fire3dv_listener_rejected_total", "counter", "Messages and peers that a listener refused.");
  for (const StreamReceiver::LinkReport& link : numbers.links) {
    for (size_t i = 0; i < transport::kCauseCount; ++i)
      page.sample(
          {{"listener", link.uri}, {"cause", transport::cause_name(static_cast<transport::Cause>(i))}},
          link.stats.rejected_by_cause[i]);
  }
  page.family("fire3dv_messages_refused_total", "counter", "Whole messages that were turned away.");
  for (size_t i = 0; i < kRefusalCount; ++i)
    page.sample({{"cause", refusal_name(static_cast<Refusal>(i))}}, numbers.refusals[i]);
}

void RendererMetrics::write_streams(metrics::Exposition& page, const Numbers& numbers, int64_t now_ns) {
  // Labels use the number: names need not be unique.
  const auto each = [&](const char* name, const char* type, const char* help, auto write) {
    page.family(name, type, help);
    for (const StreamNumbers& stream : numbers.streams) write(std::to_string(stream.report.id), stream);
  };
  using Id = const std::string&;
  using Of = const StreamNumbers&;
  each("fire3dv_stream_info", "gauge", "Name, origin and clock source of a stream.", [&](Id id, Of of) {
    page.sample({{"stream", id},
                 {"name", of.name},
                 {"listener", of.report.listener},
                 {"clock", name_of(of.report.clock)}},
                uint64_t{1});
  });
  each("fire3dv_stream_state", "gauge", "1 for the state of a stream: live, late or lost.",
       [&](Id id, Of of) {
         for (const auto condition : {state::Condition::live, state::Condition::late, state::Condition::lost})
           page.sample({{"stream", id}, {"state", name_of(condition)}}, uint64_t{of.condition == condition});
       });
  each("fire3dv_stream_nodes", "gauge", "Nodes of a stream, and those of them that move nothing here.",
       [&](Id id, Of of) {
         page.sample({{"stream", id}, {"kind", "all"}}, of.nodes);
         page.sample({{"stream", id}, {"kind", "unmatched"}}, of.unmatched);
         page.sample({{"stream", id}, {"kind", "conflicting"}}, of.conflicting);
       });
  each("fire3dv_stream_frames_received_total", "counter", "Frames that came whole and new.",
       [&](Id id, Of of) {
         page.sample({{"stream", id}}, of.received);
       });
  each("fire3dv_stream_frames_shown_total", "counter", "Frames that an image shows.", [&](Id id, Of of) {
    page.sample({{"stream", id}}, of.drawn.frames);
  });
  each("fire3dv_stream_frames_dropped_total", "counter", "Frames, or parts of them, that are not shown.",
       [&](Id id, Of of) {
         page.sample({{"stream", id}, {"cause", "incomplete"}}, of.incomplete);
         page.sample({{"stream", id}, {"cause", "stale"}}, of.stale);
         page.sample({{"stream", id}, {"cause", "refused"}}, of.refused);
         page.sample({{"stream", id}, {"cause", "baseless"}}, of.baseless);
         page.sample({{"stream", id}, {"cause", "overtaken"}}, of.overtaken);
       });
  each("fire3dv_stream_frames_held_total", "counter", "Frames that had to wait for scene edits.",
       [&](Id id, Of of) {
         page.sample({{"stream", id}}, of.held);
       });
  each(
      "fire3dv_stream_drawing_seconds_total", "counter",
      "Drawing time of the stream's markers, nodes and vertices, measured while several peers are connected.",
      [&](Id id, Of of) {
        page.sample({{"stream", id}}, of.draw_cost.seconds);
      });
  each("fire3dv_stream_drawing_share", "gauge",
       "Share of that content in the drawing time of the last seconds.", [&](Id id, Of of) {
         page.sample({{"stream", id}}, of.draw_cost.share);
       });
  each("fire3dv_stream_content_hidden", "gauge",
       "1 while that content is hidden because it slows down the images of others.", [&](Id id, Of of) {
         page.sample({{"stream", id}}, uint64_t{of.draw_cost.is_hidden});
       });
  each("fire3dv_stream_age_seconds", "gauge", "Since the shown frame was published.", [&](Id id, Of of) {
    if (of.drawn.has_publish_time)
      page.sample({{"stream", id}}, static_cast<double>(now_ns - of.drawn.published_ns) * 1e-9);
  });
  each("fire3dv_stream_latency_seconds", "histogram",
       "From a frame's publication to the submission of the first image that shows it.", [&](Id id, Of of) {
         page.histogram({{"stream", id}}, of.drawn.latency);
       });
}

void RendererMetrics::write_edits(metrics::Exposition& page, const Numbers& numbers) {
  page.family("fire3dv_stream_edits_total", "counter", "Scene edits that came.");
  for (const StreamNumbers& stream : numbers.streams) {
    const std::string id = std::to_string(stream.report.id);
    page.sample({{"stream", id}, {"outcome", "taken"}}, stream.edits_received);
    page.sample({{"stream", id}, {"outcome", "stale"}}, stream.edits_stale);
    page.sample({{"stream", id}, {"outcome", "refused"}}, stream.edits_refused);
  }
  page.family("fire3dv_edits_without_effect_total", "counter",
              "Scene edits of all streams that were taken and change nothing.");
  page.sample({{"cause", "conflicting"}}, numbers.edit_faults.conflicting);
  page.sample({{"cause", "unmatched"}}, numbers.edit_faults.unmatched);
  page.sample({{"cause", "unfit"}}, numbers.edit_faults.unfit);
  page.sample({{"cause", "refused"}}, numbers.edit_faults.refused);
  page.sample({{"cause", "skipped"}}, numbers.edit_faults.skipped);
}

}  // namespace fire3dv::app
