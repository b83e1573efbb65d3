#include "renderer/window/view_control.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace fire3dv::app {

namespace {

using sinks::Button;
using sinks::InputEvent;
using sinks::Key;

void change_speed(ViewState& view_state, float steps) {
  view_state.camera_speed = std::clamp(view_state.camera_speed * std::pow(1.25f, steps), 1.0f / 64, 64.0f);
}

void hide(ViewState& view_state, bool all_shown) {
  if (all_shown) {
    view_state.edits.hidden.clear();
    view_state.edits.isolated = scene::kNone;
  } else if (view_state.selected != scene::kNone && view_state.edits.hidden.erase(view_state.selected) == 0) {
    view_state.edits.hidden.insert(view_state.selected);
  }
}

// Keys that act again while they are held.
bool moves_timeline(Key key) {
  return key == Key::left || key == Key::right || key == Key::comma || key == Key::period;
}

void toggle(uint32_t& node, uint32_t selected) {
  node = node == selected ? scene::kNone : selected;
}

}  // namespace

CameraMoves ViewInput::take(const sinks::WindowInput& input, bool view_has_mouse, ViewState& view_state) {
  CameraMoves moves;
  scale_ = input.scale;
  for (const InputEvent& event : input.events) {
    if (event.kind != InputEvent::Kind::leave) cursor_px_ = event.cursor_px;
    switch (event.kind) {
      case InputEvent::Kind::move:
        move(event, moves);
        break;
      case InputEvent::Kind::button:
        if (!event.down) {
          const bool click = dragging_ == Button::left && event.button == Button::left && !dragged_ &&
                             !pans_ && !drags_body_;
          if (click) moves.click_px = event.cursor_px;
          if (dragging_ == event.button) {
            dragging_.reset();
            drags_body_ = false;
          }
        } else if (view_has_mouse && !dragging_) {
          dragging_ = event.button;
          dragged_ = false;
          pans_ = event.button != Button::left || event.modifiers.shift;
          pressed_px_ = event.cursor_px;
          drags_body_ = !pans_ && event.modifiers.control && view_state.can_drag_bodies;
          if (drags_body_) moves.grab_px = event.cursor_px;
        }
        break;
      case InputEvent::Kind::wheel:
        if (!view_has_mouse) break;
        if (event.modifiers.control) {
          change_speed(view_state, event.wheel.y);
        } else {
          moves.zoom_notches += event.wheel.y;
        }
        break;
      case InputEvent::Kind::key:
        if (!event.down) {
          held_.erase(event.key);
        } else {
          if (!event.modifiers.control && !event.modifiers.alt) held_.insert(event.key);
          if (!event.repeated || moves_timeline(event.key)) press(event, view_state);
        }
        break;
      case InputEvent::Kind::focus:
        if (!event.down) {
          held_.clear();
          if (std::exchange(drags_body_, false)) dragging_.reset();
        }
        break;
      default:
        break;
    }
  }
  moves.cursor_px = cursor_px_;
  moves.is_dragging_body = drags_body_;
  const auto axis = [&](char plus, char minus) {
    return static_cast<float>(held_.contains(sinks::letter(plus))) -
           static_cast<float>(held_.contains(sinks::letter(minus)));
  };
  moves.fly = {axis('d', 'a'), axis('e', 'q'), axis('s', 'w')};
  return moves;
}

void ViewInput::move(const InputEvent& event, CameraMoves& moves) {
  if (!dragging_ || drags_body_) return;
  constexpr float kTremblePx = 3;
  const glm::vec2 from = dragged_ ? last_px_ : pressed_px_;
  if (!dragged_ && glm::length(event.cursor_px - from) <= kTremblePx * scale_) return;
  dragged_ = true;
  (pans_ ? moves.pan_px : moves.orbit_px) += event.cursor_px - from;
  last_px_ = event.cursor_px;
}

void ViewInput::press(const InputEvent& event, ViewState& view_state) {
  if (event.modifiers.control && !event.modifiers.alt && !event.modifiers.super)
    return press_with_control(event, view_state);
  if (event.modifiers.control || event.modifiers.alt || event.modifiers.super) return;
  const bool shift = event.modifiers.shift;
  const Key key = event.key;
  if (key >= Key::digit_1 && key <= Key::digit_9)
    view_state.commands.camera = static_cast<size_t>(key) - static_cast<size_t>(Key::digit_1);
  if (key == Key::digit_0) view_state.commands.free_camera = true;
  if (key == sinks::letter('f') && shift)
    view_state.commands.focus_on_point = true;
  else if (key == sinks::letter('f'))
    (view_state.selected == scene::kNone ? view_state.commands.frame_all
                                         : view_state.commands.frame_selection) = true;
  if (key == Key::home) view_state.commands.frame_all = true;
  if (key == sinks::letter('h')) hide(view_state, shift);
  if (key == Key::remove && view_state.selected != scene::kNone)
    view_state.edits.removed.insert(std::exchange(view_state.selected, scene::kNone));
  if (key == sinks::letter('i')) toggle(view_state.edits.isolated, view_state.selected);
  if (key == sinks::letter('t')) toggle(view_state.followed, view_state.selected);
  if (key == sinks::letter('x')) view_state.shows_grid = !view_state.shows_grid;
  if (key == sinks::letter('k')) view_state.shows_frusta = !view_state.shows_frusta;
  if (key == sinks::letter('m')) {
    view_state.measures = !view_state.measures;
    view_state.measured.clear();
  }
  if (key == sinks::letter('p')) view_state.commands.screenshot = true;
  if (key == sinks::letter('v')) view_state.commands.toggle_video = true;
  const auto choose_tool = [&](char letter, GizmoTool tool) {
    if (key == sinks::letter(letter)) view_state.tool = view_state.tool == tool ? GizmoTool::none : tool;
  };
  choose_tool('g', GizmoTool::move);
  choose_tool('r', GizmoTool::rotate);
  choose_tool('c', GizmoTool::scale);
  if (key == sinks::letter('l')) view_state.tool_is_local = !view_state.tool_is_local;
  constexpr double kSkipS = 1, kLongSkipS = 10;
  if (key == Key::space) view_state.commands.toggle_playback = true;
  if (key == Key::left) view_state.commands.skip_s -= shift ? kLongSkipS : kSkipS;
  if (key == Key::right) view_state.commands.skip_s += shift ? kLongSkipS : kSkipS;
  if (key == Key::comma) --view_state.commands.step_frames;
  if (key == Key::period) ++view_state.commands.step_frames;
  if (key == Key::equal) change_speed(view_state, 1);
  if (key == Key::minus) change_speed(view_state, -1);
  if (key == Key::f1) view_state.help = !view_state.help;
  if (key == Key::tab) view_state.gui = !view_state.gui;
  if (key == Key::escape) {
    // Escape closes help, ends measuring, then the gizmo, then clears the selection. It never closes the
    // window.
    if (std::exchange(view_state.help, false)) return;
    if (std::exchange(view_state.measures, false)) return view_state.measured.clear();
    if (std::exchange(view_state.tool, GizmoTool::none) != GizmoTool::none) return;
    view_state.picked_point.reset();
    view_state.selected = scene::kNone;
  }
}

void ViewInput::press_with_control(const InputEvent& event, ViewState& view_state) {
  Commands& commands = view_state.commands;
  if (event.key == sinks::letter('q')) commands.close = true;
  if (event.key == sinks::letter('z')) (event.modifiers.shift ? commands.redo : commands.undo) = true;
  if (event.key == sinks::letter('y')) commands.redo = true;
  if (event.key == sinks::letter('d')) commands.duplicate = true;
  if (event.key == sinks::letter('s'))
    (event.modifiers.shift ? commands.export_glb : commands.save_overlay) = true;
}

passes::Inspection inspection_of(const ViewState& view_state, std::optional<glm::vec2>& clicked_px,
                                 glm::uvec2 image_px, uint64_t scene_number) {
  passes::Inspection inspection{view_state.debug_view, view_state.selected, {}};
  const auto clicked = std::exchange(clicked_px, std::nullopt);
  if (!clicked || clicked->x < 0 || clicked->y < 0) return inspection;
  const glm::uvec2 pixel(*clicked);
  if (pixel.x < image_px.x && pixel.y < image_px.y)
    inspection.pick = passes::Pick{pixel.x, pixel.y, scene_number};
  return inspection;
}

namespace {

// Puts the plane in focus through the picked point; a pinhole gets a lens.
void focus_on_point(ViewState& view_state, const CameraRig::Placed& placed, const state::PoseState& poses) {
  if (!view_state.picked_point || placed.camera.orthographic) return;
  const glm::vec3 eye(placed.world_from_camera[3]);
  const glm::vec3 look = -glm::normalize(glm::vec3(placed.world_from_camera[2]));
  const float distance_m = glm::dot(position_world(*view_state.picked_point, poses) - eye, look);
  if (!(distance_m >= scene::kMinFocusDistanceM && distance_m <= scene::kMaxFocusDistanceM)) return;
  scene::ThinLens& lens = view_state.draw.post.lens;
  if (lens.is_pinhole()) lens = scene::kUsualLens;
  lens.focus_distance_m = distance_m;
  view_state.paths.lens = lens;
  if (view_state.draw.path) view_state.draw.path->lens = lens;
}

}  // namespace

void move_camera(CameraRig& camera, const CameraMoves& moves, ViewState& view_state,
                 const state::PoseState& poses, glm::uvec2 image_px, float seconds) {
  constexpr float kOrbitRadPerHeight = 3.0f;
  constexpr float kRadiiPerSecond = 0.5f;
  constexpr float kLongestStep_s = 0.1f;  // time step limit: no jump after a pause
  const glm::vec2 size = glm::max(glm::vec2(image_px), glm::vec2(1));
  const float aspect = size.x / size.y;

  Commands& commands = view_state.commands;
  if (const auto chosen = std::exchange(commands.camera, {})) camera.select(*chosen);
  if (std::exchange(commands.free_camera, false)) camera.let_go(poses);
  if (std::exchange(commands.focus_on_point, false))
    focus_on_point(view_state, camera.placed(poses, aspect), poses);
  if (std::exchange(commands.frame_all, false)) camera.frame_all(aspect);
  if (std::exchange(commands.frame_selection, false)) {
    if (view_state.selected == scene::kNone) {
      camera.frame_all(aspect);
    } else {
      camera.frame_node(poses, view_state.selected, aspect);
    }
  }
  camera.follow(poses, view_state.followed);

  if (moves.orbit_px != glm::vec2(0)) {
    camera.orbit(poses, -moves.orbit_px.x / size.y * kOrbitRadPerHeight,
                 moves.orbit_px.y / size.y * kOrbitRadPerHeight);
  }
  if (moves.pan_px != glm::vec2(0)) camera.pan(poses, -moves.pan_px.x / size.y, moves.pan_px.y / size.y);
  if (moves.zoom_notches != 0) {
    const float factor = std::pow(0.85f, moves.zoom_notches);
    camera.zoom(poses, factor, 2.0f * moves.cursor_px / size - 1.0f, aspect);
  }
  if (moves.fly != glm::vec3(0)) {
    const float step_s = std::clamp(seconds, 0.0f, kLongestStep_s);
    camera.fly(poses, moves.fly,
               kRadiiPerSecond * camera.scene_radius_m() * view_state.camera_speed * step_s);
  }
}

void control_timeline(Commands& commands, replay::TimelineControl* timeline) {
  const bool toggles = std::exchange(commands.toggle_playback, false);
  const int frames = std::exchange(commands.step_frames, 0);
  const double skip_s = std::exchange(commands.skip_s, 0);
  if (!timeline) return;
  const replay::TimelineState now = timeline->timeline();
  if (toggles) now.playing && !now.at_end ? timeline->pause() : timeline->play();
  constexpr int kMaxSteps = 30;  // a slow image does not make many of them
  for (int i = 0; i < std::min(frames, kMaxSteps); ++i) timeline->step();
  for (int i = 0; i < std::min(-frames, kMaxSteps); ++i) timeline->step_back();
  if (skip_s == 0) return;
  const double end = static_cast<double>(std::max(now.end_ns, now.start_ns) - now.start_ns);
  const double at =
      static_cast<double>(std::max(now.position_ns, now.start_ns) - now.start_ns) + skip_s * 1e9;
  timeline->seek(now.start_ns + static_cast<uint64_t>(std::clamp(at, 0.0, end)));
}

void move_cameras(CameraRig& left, CameraRig* right, CameraMoves moves, ViewState& view_state,
                  const state::PoseState& poses, glm::uvec2 image_px, float seconds) {
  const auto width = static_cast<float>(image_px.x);
  const bool is_right = right && moves.cursor_px.x >= width;
  if (is_right) moves.cursor_px.x -= width;
  move_camera(is_right ? *right : left, moves, view_state, poses, image_px, seconds);
  if (right) (is_right ? left : *right).follow(poses, view_state.followed);
}

}  // namespace fire3dv::app
