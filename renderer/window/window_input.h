// Input events of a window in the order of their occurrence, and the key map from GLFW. Plain data,
// independent of a window.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/gui/input.h"

namespace fire3dv::sinks {

using gui::Button;
using gui::Key;
using gui::letter;

struct Modifiers {
  bool shift = false, control = false, alt = false, super = false;
};

struct InputEvent {
  enum class Kind : uint8_t {
    move,    // cursor movement
    button,  // pressed or released
    wheel,
    key,    // pressed, released or repeated
    text,   // character input
    focus,  // gained (down) or lost
    leave,  // cursor left the window
  };
  Kind kind = Kind::move;
  Modifiers modifiers;
  glm::vec2 cursor_px{0};  // image pixels, origin top left
  glm::vec2 wheel{0};      // right and up, in notches
  Button button = Button::left;
  Key key = Key::other;
  bool down = false, repeated = false;
  char32_t text = 0;
};

struct WindowInput {
  std::vector<InputEvent> events;
  std::vector<std::filesystem::path> dropped;  // dropped files
  float scale = 1;                             // content scale: 1 on a standard-density display
};

// Key of a GLFW key number.
Key key_of(int glfw_key);

}  // namespace fire3dv::sinks
