#include "renderer/browser/live_view.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/random.h"
#include "renderer/browser/live_joints.h"
#include "renderer/browser/live_messages.h"
#include "renderer/images/image_camera.h"
#include "renderer/passes/path/path_pass.h"
#include "renderer/passes/view/view.h"

namespace fire3dv::app {
namespace {

// Larger canvases get smaller images, which the browser scales.
constexpr double kMaxImagePixels = 4'194'304;
constexpr uint32_t kMinImageSide = 16;
constexpr auto kViewerBusyTime = std::chrono::seconds(1);
constexpr auto kReportPeriod = std::chrono::milliseconds(500);
constexpr auto kSettingsPeriod = std::chrono::milliseconds(100);
constexpr auto kInputsPeriod = std::chrono::milliseconds(100);

// JavaScript's numbers are exact up to 2^53.
uint64_t random_scene_number() {
  return random_id() >> 11;
}

// is_even: for subsampled colours.
glm::uvec2 image_size(uint32_t width, uint32_t height, float scale, bool is_even) {
  const double pixels = static_cast<double>(width) * height;
  const double factor = std::min(static_cast<double>(scale), std::sqrt(kMaxImagePixels / pixels));
  const auto side = [&](uint32_t full) {
    const auto scaled = static_cast<uint32_t>(std::lround(full * factor));
    const uint32_t size = std::max(scaled, std::min(full, kMinImageSide));
    return is_even && size > 1 ? size - size % 2 : size;
  };
  return {side(width), side(height)};
}

wire::ImageRequest make_request(uint64_t epoch, uint64_t id, uint32_t place, const CameraRig::Placed& placed,
                                const passes::Intrinsics& intrinsics) {
  wire::ImageRequest request;
  request.epoch = epoch;
  request.id = id;
  request.place = place;
  request.parent_from_camera = affine_of(placed.world_from_camera);
  request.intrinsics = {intrinsics.image_px.x, intrinsics.image_px.y, intrinsics.fx_px,
                        intrinsics.fy_px,      intrinsics.cx_px,      intrinsics.cy_px,
                        intrinsics.near_m,     intrinsics.far_m,      {}};
  return request;
}

}  // namespace

LiveView::LiveView(const Borrowed& borrowed, const CameraRig& camera, std::string title)
    : borrowed_(borrowed), start_(camera), title_(std::move(title)), scene_number_(random_scene_number()) {
  start_.set_edits(borrowed_.scene.edits());
  borrowed_.replies.set_viewers(this);
  borrowed_.scene.on_scene_replaced(
      [this](const scene::Scene&, const scene::Scene& after) { on_scene_replaced(after); });
  borrowed_.server.report_viewers_again();
}

LiveView::~LiveView() {
  for (const auto& [number, viewer] : viewers_) borrowed_.receiver.inputs().release(input_viewer(number));
  borrowed_.replies.set_viewers(nullptr);
}

void LiveView::on_scene_replaced(const scene::Scene& after) {
  start_.set_scene(after);
  for (auto& [number, viewer] : viewers_) {
    viewer.camera.set_scene(after);
    viewer.camera_node.reset();
    viewer.pick.reset();                                            // its answer has numbers of the old scene
    if (viewer.framing && *viewer.framing) viewer.framing.reset();  // so has its node
  }
  scene_number_ = random_scene_number();
  sent_.scene.clear();
  sent_.visibility.clear();
  sent_.joints.clear();
  sent_.joint_positions.clear();
}

LiveView::Viewer* LiveView::find(state::RequesterId requester) {
  const auto known = viewers_.find(requester - kFirstViewer);
  return known == viewers_.end() ? nullptr : &known->second;
}

void LiveView::send_to_all(const std::string& text) {
  for (const auto& [number, viewer] : viewers_) borrowed_.server.send(number, text);
}

void LiveView::join(serve::ViewerId number, serve::Access access) {
  uint64_t listed = 1;
  const auto is_used = [&](const auto& entry) { return entry.second.listed_number == listed; };
  while (std::ranges::any_of(viewers_, is_used)) ++listed;
  viewers_.insert_or_assign(number, Viewer{access, start_, listed});
  const std::string view_link = borrowed_.server.link(serve::Access::view);
  borrowed_.server.send(number, welcome_message(title_, access == serve::Access::control,
                                                view_link.substr(view_link.find('#') + 1)));
  for (const std::string* text :
       {&sent_.scene, &sent_.visibility, &sent_.settings, &sent_.joints, &sent_.joint_positions})
    if (!text->empty()) borrowed_.server.send(number, *text);
  if (access == serve::Access::control && inputs_.number() != 0)
    borrowed_.server.send(number, inputs_.message());
  reported_ = {};
  viewers_changed_ = true;
}

void LiveView::send_viewers() {
  std::vector<ListedViewer> listed;
  for (const auto& [number, viewer] : viewers_)
    listed.push_back({viewer.listed_number, viewer.access == serve::Access::control});
  std::ranges::sort(listed, {}, &ListedViewer::number);
  for (const auto& [number, viewer] : viewers_)
    borrowed_.server.send(number, viewers_message(listed, viewer.listed_number));
  viewers_changed_ = false;
}

size_t LiveView::count_viewers(serve::Access access) const {
  return static_cast<size_t>(
      std::ranges::count_if(viewers_, [&](const auto& entry) { return entry.second.access == access; }));
}

void LiveView::poll(replay::TimelineControl* timeline) {
  const Clock::time_point now = Clock::now();
  for (serve::Event& event : borrowed_.server.take_events()) {
    switch (event.kind) {
      case serve::Event::Kind::joined:
        join(event.viewer, event.access);
        break;
      case serve::Event::Kind::left:
        viewers_.erase(event.viewer);
        borrowed_.receiver.inputs().release(input_viewer(event.viewer));
        viewers_changed_ = true;
        if (passes::PathPass* const paths = borrowed_.renderer.path_tracer())
          paths->forget(kFirstViewer + event.viewer);
        borrowed_.requests.on_requester_ended(kFirstViewer + event.viewer);
        break;
      case serve::Event::Kind::message:
        if (const auto known = viewers_.find(event.viewer); known != viewers_.end())
          apply(event.viewer, known->second, event.message, timeline);
        break;
    }
  }
  if (viewers_.empty()) return;
  if (viewers_changed_) send_viewers();
  if (sent_.scene.empty()) {
    sent_.scene = scene_message(borrowed_.scene.scene(), scene_number_);
    send_to_all(sent_.scene);
  }
  const DocumentState& shared = borrowed_.document;
  if (sent_.visibility.empty() || sent_.hidden != shared.edits.hidden ||
      sent_.isolated != shared.edits.isolated) {
    sent_.hidden = shared.edits.hidden;
    sent_.isolated = shared.edits.isolated;
    sent_.visibility = visibility_message(shared, scene_number_);
    send_to_all(sent_.visibility);
  }
  send_settings(now);
  send_inputs(now);
  send_plots(now);
  frame_one();
  note_moment();
  for (auto& [number, viewer] : viewers_) {
    if (const uint32_t node = viewer.camera.node(); viewer.camera_node != node) {
      viewer.camera_node = node;
      borrowed_.server.send(number, camera_message(borrowed_.scene.scene(), node));
    }
    request_image(number, viewer, now);
    send_path_progress(number, viewer, now);
  }
  if (now - reported_ >= kReportPeriod) report(now, timeline);
}

void LiveView::report(Clock::time_point now, replay::TimelineControl* timeline) {
  const double seconds =
      reported_ == Clock::time_point() ? 0 : std::chrono::duration<double>(now - reported_).count();
  send_to_all(status_message(borrowed_.poses, seconds, frames_of_stream_, timeline));
  for (auto& [number, viewer] : viewers_) {
    const std::optional<CameraRig::FreeView> view = viewer.camera.free_view();
    if (viewer.view == view) continue;
    viewer.view = view;
    borrowed_.server.send(number, view_message(view));
  }
  reported_ = now;
}

void LiveView::send_if_changed(std::string& sent, std::string text) {
  if (sent == text) return;
  sent = std::move(text);
  send_to_all(sent);
}

void LiveView::send_settings(Clock::time_point now) {
  if (borrowed_.robot) (void)borrowed_.robot->set(borrowed_.document.edits.joints);
  if (now - settings_sent_ < kSettingsPeriod) return;
  settings_sent_ = now;
  const auto can = [this](const settings::DrawSettings& wanted) { return can_draw(wanted); };
  send_if_changed(sent_.settings,
                  settings_message(settings::draw_setting_table(), borrowed_.document.draw, can));
  if (!borrowed_.robot) return;
  if (sent_.joints.empty()) send_if_changed(sent_.joints, joints_message(*borrowed_.robot, scene_number_));
  send_if_changed(sent_.joint_positions,
                  joint_positions_message(*borrowed_.robot, borrowed_.poses, borrowed_.document.edits.joints,
                                          scene_number_));
}

// To those who may use them.
void LiveView::send_inputs(Clock::time_point now) {
  if (now - inputs_sent_ < kInputsPeriod || !inputs_.update(borrowed_.receiver.inputs(), borrowed_.poses))
    return;
  inputs_sent_ = now;
  for (const auto& [number, viewer] : viewers_)
    if (viewer.access == serve::Access::control) borrowed_.server.send(number, inputs_.message());
}

void LiveView::send_plots(Clock::time_point now) {
  const auto is_open = [](const auto& entry) { return entry.second.plots.is_open(); };
  if (std::ranges::none_of(viewers_, is_open)) return;
  if (scalars_.number() == 0 || now - reported_ >= kReportPeriod) (void)scalars_.update(borrowed_.poses);
  for (auto& [number, viewer] : viewers_) {
    if (viewer.plots.take_list(scalars_, now)) borrowed_.server.send(number, scalars_.message());
    if (std::optional<std::string> samples = viewer.plots.take_samples(borrowed_.poses, now))
      borrowed_.server.send(number, std::move(*samples));
  }
}

bool LiveView::is_busy() const {
  const Clock::time_point now = Clock::now();
  return std::ranges::any_of(viewers_, [&](const auto& entry) {
    const Viewer& viewer = entry.second;
    return viewer.flight || viewer.pick || viewer.framing || now - viewer.changed < kViewerBusyTime;
  });
}

// Images of requests are perspective ones: an orthographic camera becomes a free camera at its pose.
CameraRig::Placed LiveView::place(Viewer& viewer) const {
  const float aspect = viewer.aspect();
  CameraRig::Placed placed = viewer.camera.placed(borrowed_.poses, aspect);
  if (!placed.camera.orthographic) return placed;
  viewer.camera.let_go(borrowed_.poses);
  return viewer.camera.placed(borrowed_.poses, aspect);
}

// Requests an image if the viewer has none in flight, and there is something new; or a refined one, if the
// view stands.
void LiveView::request_image(serve::ViewerId number, Viewer& viewer, Clock::time_point now) {
  if (viewer.width == 0) return;
  const CameraRig::Placed placed = place(viewer);
  const bool is_new = viewer.has_moved || viewer.drawn != revisions_ || viewer.drawn_camera != placed.camera;
  if (is_new) withdraw_refinement(number, viewer);
  if (viewer.flight) return;
  if (is_new) viewer.changed = now;
  const bool stands = !is_new && viewer.can_refine && now - viewer.changed >= kRefineAfter;
  const bool refines = stands && (!viewer.is_refined || viewer.is_retouched || lacks_samples(viewer)) &&
                       take_turn(viewer, now);
  if (!is_new && !refines) return;
  if (!refines || !viewer.is_refined) viewer.samples = 0;
  const AdaptiveQuality::Step step = refines ? AdaptiveQuality::kRefined : viewer.quality.step();
  const glm::uvec2 size = image_size(viewer.width, viewer.height, step.scale, !refines);
  const uint64_t id = ++viewer.last_request;
  viewer.appearance = {viewer.camera.ground(),
                       placed.camera.exposure,
                       placed.camera.lens,
                       true,
                       viewer.samples,
                       refines,
                       !refines};
  viewer.is_retouched = false;
  viewer.flight = Flight{id, now, step, refines, 0, 0};
  viewer.drawn = revisions_;
  viewer.drawn_camera = placed.camera;
  viewer.has_moved = false;
  viewer.is_refined = refines;
  const wire::ImageRequest request =
      make_request(kEpoch, id, kImagePlace, placed, passes::intrinsics_of(placed.camera, size));
  borrowed_.requests.on_image_request(kFirstViewer + number, request, nullptr);
}

// One pixel of the view: an image whose centre is displaced.
void LiveView::request_pick(serve::ViewerId number, Viewer& viewer, double x, double y) {
  const CameraRig::Placed placed = place(viewer);
  passes::Intrinsics intrinsics = passes::intrinsics_of(placed.camera, {viewer.width, viewer.height});
  const auto pixel = [](double fraction, uint32_t side) {
    return static_cast<float>(std::min(std::floor(fraction * side), side - 1.0));
  };
  intrinsics.cx_px -= pixel(x, viewer.width);
  intrinsics.cy_px -= pixel(y, viewer.height);
  intrinsics.image_px = {1, 1};
  viewer.pick = ++viewer.last_request;
  wire::ImageRequest request = make_request(kEpoch, *viewer.pick, kPickPlace, placed, intrinsics);
  request.outputs = wire::kInstanceU32;
  borrowed_.requests.on_image_request(kFirstViewer + number, request, nullptr);
}

void LiveView::send_picked(serve::ViewerId number, uint32_t instance) {
  const std::optional<uint32_t> node = instance == 0 ? std::nullopt : std::optional(instance - 1);
  borrowed_.server.send(
      number, picked_message("picked", borrowed_.scene.scene(), borrowed_.poses, node, scene_number_));
}

std::optional<ImageReplies::Shown> LiveView::shown(state::RequesterId requester) const {
  const auto known = viewers_.find(requester - kFirstViewer);
  if (known == viewers_.end()) return {};
  return Shown{{kEpoch, kSequence, borrowed_.poses.sim_time_ns().value_or(0)}, {}, known->second.appearance};
}

// The viewer gets smaller images, and no refined one for this canvas.
void LiveView::refuse_image(state::RequesterId requester, const wire::ImageRefused& refused, bool) {
  Viewer* const viewer = find(requester);
  if (!viewer) return;
  if (viewer->pick == refused.request) viewer->pick.reset();
  if (viewer->flight && viewer->flight->request == refused.request) {
    if (viewer->flight->is_refined)
      viewer->can_refine = viewer->is_in_turn = false;
    else if (viewer->quality.on_refused())
      viewer->has_moved = true;
    viewer->flight.reset();
  }
  borrowed_.server.send(requester - kFirstViewer, notice_message("no image: " + refused.message));
}

bool LiveView::send_image(state::RequesterId requester, const wire::ImageFrame& frame,
                          const transport::ListenerLink::FillPixels& fill) {
  Viewer* const viewer = find(requester);
  if (!viewer) return false;
  const bool is_pick = viewer->pick == frame.request;
  if (!is_pick && (!viewer->flight || viewer->flight->request != frame.request)) return false;
  std::vector<uint8_t> pixels(frame.pixel_bytes);
  fill(std::as_writable_bytes(std::span(pixels)));
  if (is_pick) {
    viewer->pick.reset();
    uint32_t instance = 0;
    if (pixels.size() >= sizeof instance) std::memcpy(&instance, pixels.data(), sizeof instance);
    send_picked(requester - kFirstViewer, instance);
    return true;
  }
  pixels.resize(size_t{4} * frame.intrinsics.width * frame.intrinsics.height);
  viewer->flight->number = ++viewer->images;
  viewer->samples = viewer->flight->samples;
  serve::Image image;
  image.header.number = viewer->images;
  image.header.width = static_cast<uint16_t>(frame.intrinsics.width);
  image.header.height = static_cast<uint16_t>(frame.intrinsics.height);
  image.header.is_refined = viewer->flight->is_refined && !lacks_samples(*viewer);
  // Refined images are JPEG, beside the video.
  if ((viewer->decodes_h264 || viewer->decodes_vp8) && !viewer->flight->is_refined) {
    image.header.codec = viewer->decodes_h264 ? serve::Codec::h264 : serve::Codec::vp8;
    image.may_be_vp8 = viewer->decodes_vp8;
    image.needs_key = std::exchange(viewer->needs_key, false);
  }
  image.header.sim_time_ns = frame.sim_time_ns;
  image.quality = viewer->flight->step.quality;
  image.rgba8 = std::move(pixels);
  borrowed_.server.send_image(requester - kFirstViewer, std::move(image));
  return true;
}

}  // namespace fire3dv::app
