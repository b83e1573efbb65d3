#include "renderer/app/window/viewer_input.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace fire3dv::app {
namespace {

using sinks::Button;
using sinks::InputEvent;
using sinks::Key;

void change_speed(gui::Viewer& viewer, float steps) {
  viewer.camera_speed = std::clamp(viewer.camera_speed * std::pow(1.25f, steps), 1.0f / 64, 64.0f);
}

void hide(gui::Viewer& viewer, bool all_shown) {
  if (all_shown) {
    viewer.hidden.clear();
    viewer.isolated = scene::kNone;
  } else if (viewer.selected != scene::kNone && viewer.hidden.erase(viewer.selected) == 0) {
    viewer.hidden.insert(viewer.selected);
  }
}

void toggle(uint32_t& node, uint32_t selected) {
  node = node == selected ? scene::kNone : selected;
}

}  // namespace

CameraMoves ViewerInput::take(const sinks::WindowInput& input, const Owners& owners, gui::Viewer& viewer) {
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
          const bool click = dragging_ == Button::left && event.button == Button::left && !dragged_ && !pans_;
          if (click) moves.click_px = event.cursor_px;
          if (dragging_ == event.button) dragging_.reset();
        } else if (owners.view_has_mouse && !dragging_) {
          dragging_ = event.button;
          dragged_ = false;
          pans_ = event.button != Button::left || event.modifiers.shift;
          pressed_px_ = event.cursor_px;
        }
        break;
      case InputEvent::Kind::wheel:
        if (!owners.view_has_mouse) break;
        if (event.modifiers.control) {
          change_speed(viewer, event.wheel.y);
        } else {
          moves.zoom_notches += event.wheel.y;
        }
        break;
      case InputEvent::Kind::key:
        if (!event.down) {
          held_.erase(event.key);
        } else if (owners.view_has_keyboard) {
          if (!event.modifiers.control && !event.modifiers.alt) held_.insert(event.key);
          if (!event.repeated) press(event, viewer);
        }
        break;
      case InputEvent::Kind::focus:
        if (!event.down) held_.clear();
        break;
      default:
        break;
    }
  }
  moves.cursor_px = cursor_px_;
  const auto axis = [&](char plus, char minus) {
    return static_cast<float>(held_.contains(sinks::letter(plus))) -
           static_cast<float>(held_.contains(sinks::letter(minus)));
  };
  moves.fly = {axis('d', 'a'), axis('e', 'q'), axis('s', 'w')};
  return moves;
}

void ViewerInput::move(const InputEvent& event, CameraMoves& moves) {
  if (!dragging_) return;
  constexpr float kTremblePx = 3;
  const glm::vec2 from = dragged_ ? last_px_ : pressed_px_;
  if (!dragged_ && glm::length(event.cursor_px - from) <= kTremblePx * scale_) return;
  dragged_ = true;
  (pans_ ? moves.pan_px : moves.orbit_px) += event.cursor_px - from;
  last_px_ = event.cursor_px;
}

void ViewerInput::press(const InputEvent& event, gui::Viewer& viewer) {
  if (event.modifiers.control || event.modifiers.alt || event.modifiers.super) return;
  const bool shift = event.modifiers.shift;
  const Key key = event.key;
  if (key >= Key::digit_1 && key <= Key::digit_9)
    viewer.commands.camera = static_cast<size_t>(key) - static_cast<size_t>(Key::digit_1);
  if (key == Key::digit_0) viewer.commands.free_camera = true;
  if (key == sinks::letter('f'))
    (viewer.selected == scene::kNone ? viewer.commands.frame_all : viewer.commands.frame_selection) = true;
  if (key == Key::home) viewer.commands.frame_all = true;
  if (key == sinks::letter('h')) hide(viewer, shift);
  if (key == sinks::letter('i')) toggle(viewer.isolated, viewer.selected);
  if (key == sinks::letter('t')) toggle(viewer.followed, viewer.selected);
  if (key == sinks::letter('p')) viewer.commands.screenshot = true;
  if (key == sinks::letter('v')) viewer.commands.toggle_video = true;
  if (key == Key::equal) change_speed(viewer, 1);
  if (key == Key::minus) change_speed(viewer, -1);
  if (key == Key::f1) viewer.help = !viewer.help;
  if (key == Key::tab) viewer.gui = !viewer.gui;
  if (key == Key::escape) {
    // Escape closes help, then clears the selection, then closes the window.
    if (std::exchange(viewer.help, false)) return;
    if (std::exchange(viewer.selected, scene::kNone) == scene::kNone) viewer.commands.close = true;
  }
}

}  // namespace fire3dv::app
