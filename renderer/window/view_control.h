// View control: maps keys and mouse to camera moves and commands, and applies the user's requests
// (ViewState) to scene and cameras, once per frame.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <set>

#include "protocol/replay/replay_clock.h"
#include "renderer/camera/camera_rig.h"
#include "renderer/editing/view_state.h"
#include "renderer/passes/debug/inspection.h"
#include "renderer/window/window_input.h"

namespace fire3dv::app {

// Camera moves since the last call.
struct CameraMoves {
  glm::vec2 orbit_px{0}, pan_px{0};
  float zoom_notches = 0;  // towards the point under the cursor
  glm::vec2 cursor_px{0};
  glm::vec3 fly{0};                   // -1, 0 or 1 along the camera's x, y, z while keys are held
  std::optional<glm::vec2> click_px;  // left click without a drag
  // Ctrl-drag with ViewState::can_drag_bodies: where it begins; while it lasts; its end.
  std::optional<glm::vec2> grab_px;
  bool is_dragging_body = false;
};

class ViewInput {
 public:
  // view_has_mouse: no panel uses it.
  CameraMoves take(const sinks::WindowInput& input, bool view_has_mouse, ViewState& view_state);

 private:
  void press(const sinks::InputEvent& event, ViewState& view_state);
  void press_with_control(const sinks::InputEvent& event, ViewState& view_state);
  void move(const sinks::InputEvent& event, CameraMoves& moves);

  std::set<sinks::Key> held_;
  std::optional<sinks::Button> dragging_;  // started on the view
  bool dragged_ = false;                   // exceeds the click tolerance
  bool pans_ = false, drags_body_ = false;
  glm::vec2 cursor_px_{0}, pressed_px_{0}, last_px_{0};
  float scale_ = 1;
};

// Inspection settings of an image, including picking at a click. scene_number: returned with the picked node,
// which belongs to that scene.
passes::Inspection inspection_of(const ViewState& view_state, std::optional<glm::vec2>& clicked_px,
                                 glm::uvec2 image_px, uint64_t scene_number);

// Moves the camera and executes camera commands. seconds: since the last call.
void move_camera(CameraRig& camera, const CameraMoves& moves, ViewState& view_state,
                 const state::PoseState& poses, glm::uvec2 image_px, float seconds);

// Executes the commands for the timeline. timeline: null if there is none.
void control_timeline(Commands& commands, replay::TimelineControl* timeline);

// Two images of this size side by side: moves the camera under the cursor; both follow the followed node.
// right: null for a single image.
void move_cameras(CameraRig& left, CameraRig* right, CameraMoves moves, ViewState& view_state,
                  const state::PoseState& poses, glm::uvec2 image_px, float seconds);

}  // namespace fire3dv::app
