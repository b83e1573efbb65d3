#include "renderer/window/window_view.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <utility>

#include "base/log.h"
#include "base/plural.h"
#include "renderer/editing/view_transfer.h"
#include "renderer/images/image_service.h"
#include "renderer/passes/path/path_pass.h"
#include "renderer/window/measurement.h"

namespace fire3dv::app {
namespace {

// Flag of a pick's tag, beside the number of the scene: what is under the cursor is grabbed, not selected.
constexpr uint64_t kGrab = uint64_t{1} << 63;

}  // namespace

bool CameraWindow::steer(ViewState& view_state, const state::PoseState& poses, float seconds) {
  const VkExtent2D extent = window_.framebuffer_extent();
  const bool can_drag_bodies = std::exchange(view_state.can_drag_bodies, false);  // in the first window only
  const CameraMoves moves = input_.take(window_.take_input(), true, view_state);
  view_state.can_drag_bodies = can_drag_bodies;
  if (moves.click_px) clicked_px_ = moves.click_px;
  move_camera(camera_, moves, view_state, poses, {extent.width, extent.height}, seconds);
  return !window_.should_close();
}

Result<void> CameraWindow::draw(passes::SceneRenderer& renderer, const state::PoseState& poses,
                                const ViewState& view_state, uint64_t scene_number,
                                StaleOverlay stale_overlay, bool in_motion) {
  constexpr uint64_t kPatienceNs = 10'000'000;  // acquire timeout: a hidden window must not block the others
  if (!window_.acquire(kPatienceNs)) return {};
  const VkExtent2D extent = window_.framebuffer_extent();
  const float aspect = static_cast<float>(extent.width) / static_cast<float>(extent.height);
  const passes::View view = camera_.view(poses, aspect);
  const Result<passes::PreparedFrame> prepared = renderer.prepare(
      {.extent = extent,
       .inspection = inspection_of(view_state, clicked_px_, {extent.width, extent.height}, scene_number),
       .markers = true,
       .lens = passes::has_thin_lens(view),
       .in_motion = in_motion});
  if (!prepared) return prepared.error();
  gpu::Recorder& recorder = frames_.begin();
  renderer.record(*prepared, recorder, frames_.staging(), poses, view);
  renderer.draw_stale_overlay(recorder, stale_condition(poses.streams(), stale_overlay));
  window_.record(recorder, renderer.image());
  renderer.submitted(frames_.submit(window_.waits(), window_.signals()));
  window_.present();
  return {};
}

Result<std::unique_ptr<WindowView>> WindowView::create(const Borrowed& borrowed) {
  std::unique_ptr<WindowView> view(new WindowView(borrowed));
  const scene::Scene& scene = borrowed.scene.scene();
  const auto make_camera = [&](const std::string& name) {
    Result<CameraRig> camera =
        CameraRig::create(scene, camera_start(borrowed.options.view, scene, name, borrowed.animations));
    if (!camera && !borrowed.insist)
      camera = CameraRig::create(scene, camera_start(borrowed.options.view, scene, "", borrowed.animations));
    if (camera) camera->set_edits(borrowed.scene.edits());
    return camera;
  };
  if (!borrowed.options.right_camera.empty()) {
    Result<CameraRig> right = make_camera(borrowed.options.right_camera);
    if (!right) return right.error();
    view->right_camera_.emplace(std::move(*right));
  }
  for (size_t i = 1; i < borrowed.windows.size(); ++i) {
    Result<CameraRig> camera = make_camera(borrowed.windows[i].camera);
    if (!camera) return camera.error();
    view->others_.push_back(
        std::make_unique<CameraWindow>(borrowed.device, *borrowed.windows[i].window, std::move(*camera)));
  }
  return view;
}

WindowView::WindowView(const Borrowed& borrowed)
    : borrowed_(borrowed),
      unsaved_(borrowed.editor),
      captures_(borrowed.device, borrowed.options.screenshots),
      body_drag_(borrowed.poses, borrowed.receiver.inputs()),
      recent_files_(recent_files_path([](const char* name) { return std::getenv(name); })),
      drawn_(borrowed.view_state.draw) {
  if (borrowed.options.has_panels && borrowed.options.right_camera.empty())
    panels_.emplace(borrowed.device, borrowed.view_state, borrowed.insist, borrowed.options.has_light_panels);
  if (borrowed.insist) borrowed.view_state.screenshot_size = borrowed.options.screenshot_size;
  if (Result<void> added = recent_files_.add(borrowed.options.file); !added)
    notes_.push_back(warning(added.error().message));
  measure();
  borrowed_.scene.on_scene_replaced([this](const scene::Scene&, const scene::Scene& after) {
    if (right_camera_) right_camera_->set_scene(after);
    for (const std::unique_ptr<CameraWindow>& other : others_) other->camera().set_scene(after);
  });
}

// A minimised window keeps its size.
void WindowView::measure() {
  VkExtent2D extent = first().framebuffer_extent();
  if (extent.width == 0 || extent.height == 0) {
    if (window_extent_.width != 0) return;
    extent = borrowed_.options.size;
  }
  window_extent_ = {std::max(extent.width / columns(), 1u), extent.height};
  if (!panels_ || image_extent_.width == 0) image_extent_ = window_extent_;
}

// The image fills the rectangle that panels leave. With --out it keeps the size of the window, below the
// panels. A video keeps its size, so that panels may be moved meanwhile; only a smaller window ends it.
void WindowView::place_image() {
  const glm::uvec2 window(window_extent_.width, window_extent_.height);
  const glm::uvec2 now(image_extent_.width, image_extent_.height);
  const bool fits = glm::all(glm::lessThanEqual(image_at_px_ + now, window));
  if (captures_.records_video() && fits) return;
  glm::uvec2 low(0), high(window);
  if (panels_ && !borrowed_.options.writes_images) {
    const gui::Rect rect = panels_->image_rect();
    low = glm::min(glm::uvec2(glm::max(rect.low, glm::vec2(0))), window - 1u);
    high = glm::clamp(glm::uvec2(glm::max(rect.high, glm::vec2(0))), low + 1u, window);
  }
  image_at_px_ = low;
  image_extent_ = {high.x - low.x, high.y - low.y};
}

void WindowView::steer(const gui::Facts& facts, replay::TimelineControl* timeline) {
  sinks::Window::poll_events();
  const auto now = std::chrono::steady_clock::now();
  // The time without input does not move cameras.
  constexpr float kMaxSeconds = 0.25f;
  const float seconds =
      std::min(std::chrono::duration<float>(now - std::exchange(steered_, now)).count(), kMaxSeconds);
  steer_first(seconds, facts, timeline);
  std::erase_if(others_, [&](const std::unique_ptr<CameraWindow>& other) {
    if (other->steer(borrowed_.view_state, borrowed_.poses, seconds)) return false;
    const sinks::Window* const closed = &other->window();
    std::erase_if(borrowed_.windows, [&](const OpenWindow& open) { return open.window.get() == closed; });
    return true;
  });
  apply_requests();
}

bool WindowView::take_activity() {
  sinks::Window::poll_events();
  bool is_active = std::exchange(has_picked_, false) || captures_.records_video() ||
                   (panels_ && panels_->has_waiting_events());
  for (const OpenWindow& open : borrowed_.windows) is_active |= open.window->take_activity();
  return is_active;
}

state::EditTargets WindowView::edit_targets() const {
  return {borrowed_.scene.scene(), borrowed_.poses.names(), borrowed_.robot ? &*borrowed_.robot : nullptr,
          borrowed_.scene.added_materials()};
}

void WindowView::apply_requests() {
  if (borrowed_.scene.take_variant_refusal()) {
    borrowed_.view_state.edits.variant = borrowed_.scene.variant();
    borrowed_.editor.take_shown_variant(edit_targets());
  }
  borrowed_.scene.set_user_edits(borrowed_.view_state.edits);
  if (borrowed_.robot) borrowed_.robot->set(borrowed_.view_state.edits.joints);
  apply_draw_settings();
  borrowed_.editor.record_settings(is_interacting());
  settings::DebugView& view = borrowed_.view_state.debug_view;
  if (Result<void> can = renderer().can_show(view); !can) {
    notes_.push_back(error_line(can.error().message));
    view = settings::DebugView::none;
  }
  for (const auto& [epoch, playout] : borrowed_.view_state.streams)
    borrowed_.receiver.play(epoch, playout.interpolate, playout.delay_ns);
}

// Why this window cannot switch to paths; nothing: it can.
std::optional<std::string> WindowView::why_no_paths() {
  if (Result<void> can = passes::can_trace_paths(borrowed_.device); !can) return can.error().message;
  if (columns() > 1 || !others_.empty())
    return "paths refine one view: start the viewer with one --window and without --stereo";
  if (borrowed_.options.has_secondary_devices)
    return "paths refine on one device: --device instead of --devices";
  if (borrowed_.options.has_live_view)
    return "paths refine the image of a window or those of browsers: leave --serve out, or start --headless";
  if (borrowed_.options.is_lockstep || borrowed_.options.writes_images)
    return "paths refine an image, and --lockstep and --out await whole ones: leave them out";
  return std::nullopt;
}

// Settings that need another renderer wait for the GPU: the user requested them, and a lost frame does not
// matter.
void WindowView::apply_draw_settings() {
  settings::DrawSettings& requested = borrowed_.view_state.draw;
  requested.max_textures = renderer().settings().draw().max_textures;
  if (requested.path && !renderer().traces_paths()) {
    if (const std::optional<std::string> reason = why_no_paths()) {
      notes_.push_back(error_line(*reason));
      requested.path.reset();
    } else {
      for (const std::string& limit : passes::path_tracing_limits(borrowed_.scene.scene()))
        notes_.push_back(warning(limit));
    }
  }
  if (renderer().needs_new_renderer(requested)) {
    if (borrowed_.options.has_outputs || borrowed_.requests.count() != 0) {
      notes_.push_back(
          "warning: renderer, samples, raster path and shadows stay while --outputs or a simulator wants "
          "images of one kind");
      requested = drawn_;
      return;
    }
    borrowed_.device.wait(borrowed_.device.last_submitted());
    borrowed_.renderer.emplace(borrowed_.device, requested);
    renderer().set_edits(borrowed_.scene.edits());
    renderer().set_scene(borrowed_.scene.scene(), borrowed_.scene.loaded().derived);
    borrowed_.requests.set_abilities(image_abilities(renderer()));
  }
  renderer().apply(requested);
  drawn_ = requested;
}

void WindowView::steer_first(float seconds, const gui::Facts& facts, replay::TimelineControl* timeline) {
  measure();
  ViewState& view_state = borrowed_.view_state;
  sinks::WindowInput input = first().take_input();
  display_scale_ = input.scale;
  bool view_has_mouse = true;
  if (panels_) {
    const LiveScene& scene = borrowed_.scene;
    EditFacts editing = borrowed_.editor.facts();
    editing.notice = unsaved_.notice();
    constexpr size_t kMaxRefused = 8;  // the next ones follow when these are removed
    for (auto& [name, reason] : scene.refused_additions(kMaxRefused))
      editing.refused.push_back({std::move(name), std::move(reason)});
    const auto view = [this](float aspect) { return borrowed_.camera.view(borrowed_.poses, aspect); };
    const std::vector<state::StreamId> controlled = borrowed_.receiver.inputs().streams();
    view_has_mouse = panels_->take(
        first(), input, {window_extent_.width, window_extent_.height}, seconds, facts,
        {scene.scene(), borrowed_.poses, &scene.edits(), scene.replaced(), timeline,
         borrowed_.robot ? &*borrowed_.robot : nullptr, recent_files_.files(), &editing, view, controlled},
        view_state);
    place_image();
  }
  const glm::uvec2 image_px(image_extent_.width, image_extent_.height);
  view_state.can_drag_bodies = !right_camera_ && body_drag_.is_possible();
  CameraMoves moves = input_.take(input, view_has_mouse, view_state);
  const float aspect = static_cast<float>(image_px.x) / static_cast<float>(std::max(image_px.y, 1u));
  const CameraRig::Placed seen = borrowed_.camera.placed(borrowed_.poses, aspect);
  borrowed_.editor.update(edit_targets(), is_interacting(),
                          {borrowed_.camera.focus(borrowed_.poses, aspect), seen.world_from_camera,
                           seen.camera, &borrowed_.poses});
  moves.cursor_px -= glm::vec2(image_at_px_);
  drag_body(moves);
  for (InputCommand& command : std::exchange(view_state.commands.inputs, {}))
    (void)borrowed_.receiver.inputs().act(command.epoch, 0, std::move(command.event));
  if (moves.click_px) {
    *moves.click_px -= glm::vec2(image_at_px_);
    const auto width = static_cast<float>(image_extent_.width);
    if (Result<void> can = renderer().can_inspect(); !can) notes_.push_back(error_line(can.error().message));
    const bool on_right = right_camera_ && moves.click_px->x >= width;
    if (on_right) moves.click_px->x -= width;
    (on_right ? clicked_right_px_ : clicked_px_) = moves.click_px;
  }
  move_cameras(borrowed_.camera, right_camera_ ? &*right_camera_ : nullptr, moves, view_state,
               borrowed_.poses, image_px, seconds);

  Commands& commands = view_state.commands;
  control_timeline(commands, timeline);
  if (std::exchange(commands.screenshot, false)) request_screenshot();
  if (std::exchange(commands.toggle_video, false)) captures_.toggle_video();
  if (commands.export_csv) captures_.export_csv(*std::exchange(commands.export_csv, std::nullopt));
  close_or_open(input, view_has_mouse);
}

// Other views of the first window keep their cameras: a body is dragged in a single image only.
void WindowView::drag_body(const CameraMoves& moves) {
  if (!moves.is_dragging_body) {
    if (body_drag_.is_pressed()) body_drag_.release();
    grabbed_px_.reset();
  } else {
    if (moves.grab_px) {
      body_drag_.release();
      body_drag_.press();
      grabbed_px_ = *moves.grab_px - glm::vec2(image_at_px_);
      if (Result<void> can = renderer().can_inspect(); !can)
        notes_.push_back(error_line(can.error().message));
    }
    const glm::vec2 size(image_extent_.width, image_extent_.height);
    body_drag_.move(2.0f * moves.cursor_px / size - 1.0f,
                    borrowed_.camera.view(borrowed_.poses, size.x / size.y));
  }
  borrowed_.view_state.spring = body_drag_.ends();
}

// A request that would lose unsaved edits is refused once.
void WindowView::close_or_open(const sinks::WindowInput& input, bool view_has_mouse) {
  const auto is_press = [](const sinks::InputEvent& event) {
    return event.kind == sinks::InputEvent::Kind::button && event.down;
  };
  unsaved_.update(view_has_mouse && std::ranges::any_of(input.events, is_press));
  Commands& commands = borrowed_.view_state.commands;
  if (std::exchange(commands.close, false) || first().should_close()) {
    if (!closing_) record_unfinished_edits();
    closing_ = closing_ || unsaved_.may_discard("close");
    if (!closing_) first().keep_open();
  }
  if (!input.dropped.empty()) commands.open = input.dropped.front();
  if (const auto file = std::exchange(commands.open, std::nullopt)) {
    record_unfinished_edits();
    if (!unsaved_.may_discard("open")) return;
    opened_ = file;
    unsaved_.open_document();
  }
}

void WindowView::record_unfinished_edits() {
  borrowed_.editor.update(edit_targets(), false);
}

bool WindowView::may_show_next() {
  record_unfinished_edits();
  return unsaved_.may_replace_document();
}

bool WindowView::holds_next() const {
  return unsaved_.holds_document(is_interacting());
}

void WindowView::request_screenshot() {
  const ScreenshotSize& wanted = borrowed_.view_state.screenshot_size;
  const Result<glm::uvec2> size = gui::screenshot_px(wanted, {image_extent_.width, image_extent_.height});
  if (!size) return notes_.push_back(error_line(size.error().message));
  if (wanted.kind == ScreenshotSize::Kind::window) return captures_.request_screenshot();
  if (renderer().traces_paths()) {
    notes_.push_back(
        warning("paths refine the window's image: the screenshot has its size, not the chosen one"));
    return captures_.request_screenshot();
  }
  large_screenshot_px_ = *size;
}

Result<void> WindowView::record(gpu::Recorder& recorder, gpu::StagingRing& staging,
                                ScreenshotRecorder::Tag shown, bool in_motion) {
  passes::SceneRenderer& renderer = *borrowed_.renderer;
  captures_.record(recorder, renderer.image(), shown);
  gpu::Image& content =
      panels_ ? panels_->record(recorder, staging, renderer.image(), image_at_px_, window_extent_)
              : renderer.image();
  first().record(recorder, content, 0, columns());
  if (const auto size = std::exchange(large_screenshot_px_, std::nullopt); size && !renderer.traces_paths())
    record_large_screenshot(recorder, staging, shown, *size);
  if (!right_camera_) return {};
  const float aspect = static_cast<float>(image_extent_.width) / static_cast<float>(image_extent_.height);
  const passes::View view = right_camera_->view(borrowed_.poses, aspect);
  const Result<passes::PreparedFrame> prepared = renderer.prepare(
      {.extent = image_extent_,
       .inspection = inspection_of(borrowed_.view_state, clicked_right_px_,
                                   {image_extent_.width, image_extent_.height}, borrowed_.scene.replaced()),
       .scene = passes::SceneUpdate::reuse,
       .markers = true,
       .lens = passes::has_thin_lens(view),
       .in_motion = in_motion});
  if (!prepared) return prepared.error();
  renderer.record(*prepared, recorder, staging, borrowed_.poses, view);
  renderer.draw_stale_overlay(recorder,
                              stale_condition(borrowed_.poses.streams(), borrowed_.options.stale_overlay));
  first().record(recorder, renderer.image(), 1, columns());
  return {};
}

// Tiles keep the memory of a large image small, and may exceed the largest image of the device. What depends
// on the whole image needs one tile.
void WindowView::record_large_screenshot(gpu::Recorder& recorder, gpu::StagingRing& staging,
                                         const ScreenshotRecorder::Tag& shown, glm::uvec2 size) {
  constexpr uint32_t kTileSide_px = 2048;
  const ViewState& view_state = borrowed_.view_state;
  const settings::PostSettings& post = renderer().settings().draw().post;
  const float aspect = static_cast<float>(size.x) / static_cast<float>(size.y);
  const passes::View whole = borrowed_.camera.view(borrowed_.poses, aspect);
  // Depth of field has the focal length of the whole image, and wide circles.
  const bool blurs = !(post.lens.is_pinhole() && whole.lens.is_pinhole());
  const bool needs_whole = post.bloom > 0 || post.metered || post.optics.any() || blurs ||
                           view_state.debug_view == settings::DebugView::depth;
  const uint32_t limit = borrowed_.device.limits().maxImageDimension2D;
  if (needs_whole && std::max(size.x, size.y) > limit) {
    notes_.push_back(error_line(
        "no screenshot: bloom, metered exposure, depth of field, optics of the camera and the depth view "
        "need the whole image at once, and the device draws " +
        std::to_string(limit) + " pixels a side at most; choose a smaller size, or switch them off"));
    return;
  }
  for (const ScreenshotTile& tile :
       screenshot_tiles(size, needs_whole ? limit : std::min(kTileSide_px, limit))) {
    const Result<passes::PreparedFrame> prepared =
        renderer().prepare({.extent = {tile.drawn_size.x, tile.drawn_size.y},
                            .inspection = {view_state.debug_view, view_state.selected, {}},
                            .scene = passes::SceneUpdate::reuse,
                            .markers = true,
                            .lens = passes::has_thin_lens(whole)});
    if (!prepared) {
      captures_.abandon_tiles();
      notes_.push_back(error_line("no screenshot of this size: " + prepared.error().message));
      return;
    }
    renderer().record(*prepared, recorder, staging, borrowed_.poses, view_of_tile(whole, size, tile));
    captures_.record_tile(recorder, renderer().image(), shown, size, tile);
  }
}

void WindowView::present(uint64_t timeline_value) {
  first().present();
  captures_.submitted(timeline_value);
}

Result<void> WindowView::draw_others(bool in_motion) {
  for (const std::unique_ptr<CameraWindow>& other : others_) {
    Result<void> drawn = other->draw(renderer(), borrowed_.poses, borrowed_.view_state,
                                     borrowed_.scene.replaced(), borrowed_.options.stale_overlay, in_motion);
    if (!drawn) return drawn;
  }
  return {};
}

std::span<const state::ShownMarker> WindowView::update_overlay() {
  if (borrowed_.options.writes_images) return {};
  const LiveScene& scene = borrowed_.scene;
  return overlay_.update(
      borrowed_.view_state,
      {scene.scene(), scene.edits(), borrowed_.poses, scene.replaced(), borrowed_.camera.node(),
       static_cast<float>(image_extent_.width) / static_cast<float>(image_extent_.height), display_scale_});
}

passes::Inspection WindowView::take_inspection() {
  if (grabbed_px_)
    return inspection_of(borrowed_.view_state, grabbed_px_, {image_extent_.width, image_extent_.height},
                         borrowed_.scene.replaced() | kGrab);
  return inspection_of(borrowed_.view_state, clicked_px_, {image_extent_.width, image_extent_.height},
                       borrowed_.scene.replaced());
}

void WindowView::deliver() {
  captures_.deliver();
  for (const passes::Picked& picked : renderer().take_picked()) {
    // Ignores picks in an earlier scene.
    if ((picked.tag & ~kGrab) != borrowed_.scene.replaced()) continue;
    has_picked_ = true;
    if (picked.tag & kGrab) {
      if (const std::optional<std::string> why = body_drag_.grab(picked)) notes_.push_back(*why);
      continue;
    }
    if (std::optional<std::string> message = take_pick(borrowed_.view_state, picked, borrowed_.poses))
      notes_.push_back(std::move(*message));
  }
}

std::vector<std::string> WindowView::take_log_messages() {
  borrowed_.editor.protect_unsaved();
  std::vector<std::string> notes = std::exchange(notes_, {});
  std::ranges::move(unsaved_.take_log_messages(), std::back_inserter(notes));
  std::ranges::move(captures_.take_log_messages(), std::back_inserter(notes));
  std::ranges::move(borrowed_.editor.take_log_messages(), std::back_inserter(notes));
  if (panels_) std::ranges::move(panels_->take_log_messages(), std::back_inserter(notes));
  for (const OpenWindow& open : borrowed_.windows) {
    if (std::optional<std::string> note = open.window->take_note()) notes.push_back(std::move(*note));
  }
  return notes;
}

}  // namespace fire3dv::app
