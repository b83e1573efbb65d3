#include "renderer/window/window_panels.h"

#include <algorithm>
#include <cstdlib>

#include "base/clock.h"
#include "base/log.h"
#include "renderer/metrics/metric_families.h"
#include "renderer/passes/path/path_pass.h"
#include "renderer/passes/resources/gpu_scene.h"

namespace fire3dv::app {

namespace {

std::optional<std::filesystem::path> layout_path() {
  return gui::layout_place([](const char* name) { return std::getenv(name); });
}

gui::Layout load(const std::optional<std::filesystem::path>& file, std::vector<std::string>& notes) {
  if (!file) return {};
  Result<gui::Layout> layout = gui::load_layout(*file);
  if (layout) return *layout;
  notes.push_back(warning(layout.error().message));
  return {};
}

gui::Layout with_theme(gui::Layout layout, std::optional<bool> is_light) {
  layout.is_light = is_light.value_or(layout.is_light);
  return layout;
}

gui::HeldKeys held_keys(const sinks::Modifiers& modifiers) {
  return {modifiers.control, modifiers.shift, modifiers.alt};
}

}  // namespace

gui::Input PanelInput::convert(const sinks::WindowInput& input, glm::uvec2 window_px, float seconds) {
  using Kind = sinks::InputEvent::Kind;
  gui::Input panel;
  panel.display_px = glm::vec2(window_px);
  panel.scale = input.scale;
  panel.delta_s = seconds;
  for (const sinks::InputEvent& event : input.events) {
    held_ = event.modifiers;
    switch (event.kind) {
      case Kind::move:
        panel.events.emplace_back(gui::MouseMoved{event.cursor_px});
        break;
      case Kind::button:
        panel.events.emplace_back(gui::MouseMoved{event.cursor_px});
        panel.events.emplace_back(gui::MouseButton{event.button, event.down, held_keys(held_)});
        break;
      case Kind::wheel:
        panel.events.emplace_back(gui::MouseWheel{event.wheel});
        break;
      case Kind::key:
        panel.events.emplace_back(gui::KeyChanged{event.key, event.down, event.repeated, held_keys(held_)});
        break;
      case Kind::text:
        panel.events.emplace_back(gui::Text{event.text});
        break;
      case Kind::leave:
        panel.events.emplace_back(gui::MouseLeft{});
        break;
      case Kind::focus:
        break;
    }
    waiting_.emplace_back(event, converted_ + panel.events.size());
  }
  converted_ += panel.events.size();
  panel.held = held_keys(held_);
  return panel;
}

std::vector<sinks::InputEvent> PanelInput::take_seen(const gui::Gui& gui) {
  std::vector<sinks::InputEvent> seen;
  const size_t unseen = gui.waiting_events();
  const std::vector<bool> key_uses = gui.key_uses();
  size_t keys = 0;
  for (; !waiting_.empty() && waiting_.front().second + unseen <= converted_; waiting_.pop_front()) {
    const sinks::InputEvent& event = waiting_.front().first;
    if (event.kind == sinks::InputEvent::Kind::key && key_uses.at(keys++)) continue;
    seen.push_back(event);
  }
  return seen;
}

WindowPanels::WindowPanels(gpu::Device& device, ViewState& view_state, bool first,
                           std::optional<bool> light_panels)
    : file_(layout_path()),
      saved_(load(file_, notes_)),
      gui_(with_theme(saved_, light_panels), {sinks::Window::clipboard, sinks::Window::set_clipboard}),
      pass_(device),
      device_(device) {
  if (first) view_state.camera_speed = saved_.camera_speed;
}

WindowPanels::~WindowPanels() {
  if (!file_ || gui_.layout() == saved_) return;
  if (Result<void> saved = gui::save_layout(*file_, gui_.layout()); !saved)
    log_message(warning(saved.error().message));
}

bool WindowPanels::take(sinks::Window& window, sinks::WindowInput& input, glm::uvec2 window_px, float seconds,
                        const gui::Facts& facts, const gui::Shown& shown, ViewState& view_state) {
  laid_out_ = &gui_.frame(input_.convert(input, window_px, seconds), facts, shown, view_state);
  input.events = input_.take_seen(gui_);
  window.set_cursor(static_cast<sinks::Window::Cursor>(gui_.cursor()));
  return !gui_.wants_mouse();
}

gpu::Image& WindowPanels::record(gpu::Recorder& recorder, gpu::StagingRing& staging, gpu::Image& image,
                                 glm::uvec2 at, VkExtent2D window) {
  if (!laid_out_) return image;
  const bool fills = image.extent.width == window.width && image.extent.height == window.height;
  gpu::Image& content = fills ? image : canvas_;
  if (!fills) copy_to_canvas(recorder, image, at, window);
  pass_.record(recorder, staging, content, *laid_out_, gui_.fonts(), gui_.fonts_number());
  return content;
}

void WindowPanels::copy_to_canvas(gpu::Recorder& recorder, gpu::Image& image, glm::uvec2 at,
                                  VkExtent2D window) {
  if (!canvas_ || canvas_.extent.width != window.width || canvas_.extent.height != window.height) {
    canvas_ = gpu::create_image(device_, {VK_FORMAT_R8G8B8A8_UNORM, window,
                                          VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT |
                                              VK_IMAGE_USAGE_TRANSFER_SRC_BIT});
  }
  const VkExtent2D part{std::min(image.extent.width, window.width - std::min(at.x, window.width)),
                        std::min(image.extent.height, window.height - std::min(at.y, window.height))};
  // Panels cover the rest, except while a video keeps the size of the image.
  recorder.pass("window", {gpu::Use(canvas_, gpu::access::transfer_write, true)},
                [&](VkCommandBuffer commands) {
                  constexpr VkClearColorValue kBlack{{0, 0, 0, 1}};
                  constexpr VkImageSubresourceRange kAll{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
                  vkCmdClearColorImage(commands, canvas_.get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &kBlack,
                                       1, &kAll);
                });
  recorder.pass("window",
                {gpu::Use(image, gpu::access::transfer_read), gpu::Use(canvas_, gpu::access::transfer_write)},
                [&](VkCommandBuffer commands) {
                  VkImageCopy copy{};
                  copy.srcSubresource = copy.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
                  copy.dstOffset = {static_cast<int32_t>(at.x), static_cast<int32_t>(at.y), 0};
                  copy.extent = {part.width, part.height, 1};
                  vkCmdCopyImage(commands, image.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, canvas_.get(),
                                 VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
                });
}

namespace {

using Clock = std::chrono::steady_clock;

constexpr size_t kMaxLines = 2000;
constexpr auto kMemoryInterval = std::chrono::milliseconds(500);  // interval of system calls and averages

double seconds_between(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

const char* clock_words(state::ClockOffset::Source source) {
  switch (source) {
    case state::ClockOffset::Source::none:
      return "not measured yet";
    case state::ClockOffset::Source::one_way:
      return "bounded by arrivals";
    case state::ClockOffset::Source::round_trip:
      return "measured by pings";
    case state::ClockOffset::Source::same_clock:
      return "the same as ours";
  }
  return "";
}

// Resources with more than 1 % of the peer's limit in use, or with refusals.
std::vector<gui::UseFact> notable_uses(const PeerBudget* budget) {
  std::vector<gui::UseFact> uses;
  if (!budget) return uses;
  for (const ResourceInfo& info : resource_table()) {
    const gui::UseFact use{info.resource, budget->used(info.resource), budget->limit(info.resource),
                           budget->refused(info.resource)};
    if (use.used > use.limit / 100 || use.refused > 0) uses.push_back(use);
  }
  return uses;
}

}  // namespace

void PanelFacts::note(const std::string& sentence) {
  // Drops half at once: removing single lines would move all others each time.
  if (facts_.log.size() == kMaxLines)
    facts_.log.erase(facts_.log.begin(), facts_.log.begin() + kMaxLines / 2);
  facts_.log.push_back({seconds_between(begun_, Clock::now()), sentence});
  ++facts_.log_lines;
}

void PanelFacts::drawn(uint64_t images, double frame_ms, double cpu_ms, std::optional<double> pose_age_ms) {
  facts_.frame.images = images;
  facts_.frame.interval_ms = frame_ms;
  facts_.frame.cpu_ms = cpu_ms;
  facts_.frame.pose_age_ms = pose_age_ms;
}

void PanelFacts::add(const gpu::FrameTimes& times) {
  facts_.frame.gpu_ms = times.total_ms;
  facts_.frame.passes.clear();
  for (const gpu::PassTime& pass : times.passes)
    facts_.frame.passes.push_back({pass.name, pass.milliseconds, pass.async_compute});
}

// Iterates over the scene only if the draw list changed.
void PanelFacts::set_scene(const scene::Scene& scene, uint64_t scene_number,
                           const passes::SceneRenderer& renderer) {
  const passes::GpuScene& gpu_scene = renderer.gpu_scene();
  const std::pair now(scene_number, gpu_scene.draw_list_revision);
  if (counted_ == now) return;
  counted_ = now;
  facts_.frame.triangles = 0;
  for (const passes::Draw& draw : gpu_scene.draw_list.draws) {
    const scene::Primitive& primitive = scene.primitives[draw.primitive];
    if (primitive.topology == scene::Topology::triangles) facts_.frame.triangles += primitive.index_count / 3;
  }
  facts_.frame.clusters = gpu_scene.lod0_cluster_instance_count;
}

double PanelFacts::rate_of(uint64_t epoch, uint64_t sequence) {
  Rate& rate = rates_[epoch];
  const Clock::time_point now = Clock::now();
  if (!rate.is_known) rate = {sequence, now, 0, true};
  if (now - rate.since < kMemoryInterval) return rate.hz;
  const uint64_t frames = sequence - std::min(sequence, rate.sequence);
  rate = {sequence, now, static_cast<double>(frames) / seconds_between(rate.since, now), true};
  return rate.hz;
}

gui::StreamFact PanelFacts::stream_fact(const StreamReceiver::Report& report, const StreamReceiver& receiver,
                                        const state::PoseState& poses, const state::MarkerRegistry& markers) {
  const state::Stream& stream = poses.streams()[report.id];
  gui::StreamFact fact;
  fact.epoch = stream.epoch;
  fact.name = stream.name;
  fact.listener = report.listener;
  fact.clock = clock_words(report.clock);
  fact.condition = stream.condition;
  fact.interpolated = stream.interpolated;
  fact.delay_ns = poses.delay_ns(report.id);
  fact.rate_hz = rate_of(stream.epoch, stream.header.sequence);
  if (const auto published_ns = receiver.published_ns(stream.epoch, stream.header.publish_time_ns);
      published_ns && stream.header.sequence != 0)
    fact.age_ms = static_cast<double>(monotonic_ns() - *published_ns) * 1e-6;
  fact.sequence = stream.header.sequence;
  fact.sim_time_ns = stream.header.sim_time_ns;
  fact.poses = static_cast<uint32_t>(stream.scene_node_of_pose.size());
  fact.unmatched = static_cast<uint32_t>(stream.unmatched_names.size());
  fact.conflicting = static_cast<uint32_t>(stream.conflicting_names.size());
  fact.shown = stream.frames_received;
  fact.incomplete = stream.frames_incomplete;
  fact.stale = stream.frames_stale;
  fact.refused = stream.frames_refused;
  fact.baseless = stream.frames_without_base;
  fact.overtaken = stream.frames_superseded;
  fact.edits = stream.edits_received;
  fact.edits_refused = stream.edits_refused;
  const auto& namespaces = markers.namespaces(stream.epoch);
  for (const auto& [name, count] : namespaces) {
    if (fact.marker_namespaces.size() == gui::kMaxMarkerNamespaces) break;
    fact.marker_namespaces.push_back({name, count});
  }
  fact.more_marker_namespaces = namespaces.size() - fact.marker_namespaces.size();
  if (report.budget) fact.draw_cost = report.budget->draw_cost();
  fact.uses = notable_uses(report.budget.get());
  fact.gaps_ms = poses.gaps_ms(report.id);
  return fact;
}

const gui::Facts& PanelFacts::begin_assembly(const scene::Scene& scene, uint64_t scene_number,
                                             const StreamReceiver& receiver, const state::PoseState& poses,
                                             const state::MarkerRegistry& markers,
                                             const passes::SceneRenderer& renderer, const gpu::Device& device,
                                             uint32_t camera_node, bool recording_video) {
  gui::FrameFacts& frame = facts_.frame;
  set_scene(scene, scene_number, renderer);
  const bool compute = renderer.settings().raster_path() == settings::RasterPath::visibility;
  frame.extent_px = {renderer.extent().width, renderer.extent().height};
  frame.clusters_drawn.reset();
  if (compute) frame.clusters_drawn = renderer.counts().clusters;
  frame.late_clusters = renderer.counts().late_clusters;
  frame.shadow_rays = renderer.counts().shadow_rays;
  frame.device = device.report().name;
  frame.raster = compute ? "from a visibility buffer" : "forward";
  frame.shadows = passes::describe(renderer.settings().shadow_technique());
  frame.samples = static_cast<uint32_t>(renderer.settings().samples());
  frame.paths.reset();
  if (const passes::PathPass* const paths = renderer.path_tracer()) {
    frame.paths = paths->progress();
    frame.raster = std::string("path-traced ") + passes::describe_path_back_end(paths->back_end());
    frame.shadows = "of all lights, traced";
  }
  if (const Clock::time_point now = Clock::now(); now - memory_read_at_ >= kMemoryInterval) {
    memory_read_at_ = now;
    frame.gpu_bytes = device.allocated_bytes();
    frame.resident_bytes = metrics::resident_bytes();
  }

  facts_.streams.clear();
  std::map<uint64_t, Rate> still_there;
  for (const StreamReceiver::Report& report : receiver.report()) {
    facts_.streams.push_back(stream_fact(report, receiver, poses, markers));
    still_there[facts_.streams.back().epoch] = rates_[facts_.streams.back().epoch];
  }
  rates_ = std::move(still_there);
  facts_.links.clear();
  for (const StreamReceiver::LinkReport& link : receiver.links()) {
    facts_.links.push_back({link.uri, link.stats.peers, link.stats.bytes_received, link.stats.poses_dropped,
                            link.stats.frames_dropped, link.stats.rejected});
  }
  if (std::exchange(cameras_of_, scene_number) != scene_number)
    cameras_ = scene::camera_nodes(scene);  // visits every node
  facts_.camera.reset();
  const auto camera = std::find(cameras_.begin(), cameras_.end(), camera_node);
  if (camera != cameras_.end()) facts_.camera = static_cast<size_t>(camera - cameras_.begin());
  facts_.recording_video = recording_video;
  return facts_;
}

}  // namespace fire3dv::app
