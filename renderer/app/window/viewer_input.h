// Input mapping of the viewer: keys and mouse to camera moves and commands.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <set>

#include "renderer/gui/viewer.h"
#include "renderer/sinks/window_input.h"

namespace fire3dv::app {

// Camera moves since the last call.
struct CameraMoves {
  glm::vec2 orbit_px{0}, pan_px{0};
  float zoom_notches = 0;  // towards the point under the cursor
  glm::vec2 cursor_px{0};
  glm::vec3 fly{0};                   // -1, 0 or 1 along the camera's x, y, z while keys are held
  std::optional<glm::vec2> click_px;  // left click without a drag
};

class ViewerInput {
 public:
  // Owners of mouse and keyboard: input that panels use does not move the view.
  struct Owners {
    bool view_has_mouse = true, view_has_keyboard = true;
  };
  CameraMoves take(const sinks::WindowInput& input, const Owners& owners, gui::Viewer& viewer);

 private:
  void press(const sinks::InputEvent& event, gui::Viewer& viewer);
  void move(const sinks::InputEvent& event, CameraMoves& moves);

  std::set<sinks::Key> held_;
  std::optional<sinks::Button> dragging_;  // started on the view
  bool dragged_ = false;                   // exceeds the click tolerance
  bool pans_ = false;
  glm::vec2 cursor_px_{0}, pressed_px_{0}, last_px_{0};
  float scale_ = 1;
};

}  // namespace fire3dv::app
