// What keys and the mouse mean: moves of the camera, and wishes of the user.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <set>

#include "renderer/gui/viewer.h"
#include "renderer/sinks/window_input.h"

namespace fire3dv::app {

// Of the camera, since the last look.
struct CameraMoves {
  glm::vec2 orbit_px{0}, pan_px{0};
  float zoom_notches = 0;  // to what is below the cursor
  glm::vec2 cursor_px{0};
  glm::vec3 fly{0};                   // -1, 0 or 1 along the camera's x, y, z while keys are held
  std::optional<glm::vec2> click_px;  // the left button, where it was not a drag
};

class ViewerInput {
 public:
  // Whose mouse and keyboard are: what panels want does not move the view.
  struct Owners {
    bool view_has_mouse = true, view_has_keyboard = true;
  };
  CameraMoves take(const sinks::WindowInput& input, const Owners& owners, gui::Viewer& viewer);

 private:
  void press(const sinks::InputEvent& event, gui::Viewer& viewer);
  void move(const sinks::InputEvent& event, CameraMoves& moves);

  std::set<sinks::Key> held_;
  std::optional<sinks::Button> dragging_;  // began on the view
  bool dragged_ = false;                   // farther than a hand trembles in a click
  bool pans_ = false;
  glm::vec2 cursor_px_{0}, pressed_px_{0}, last_px_{0};
  float scale_ = 1;
};

}  // namespace fire3dv::app
