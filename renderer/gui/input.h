// What keyboard and mouse do, for panels. Plain data: whoever has a window fills it, and a test does without
// one.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <variant>
#include <vector>

namespace fire3dv::gui {

// Those that panels look at; text comes as text.
enum class Key : uint8_t {
  none,
  tab,
  left,
  right,
  up,
  down,
  page_up,
  page_down,
  home,
  end,
  insert,
  del,
  backspace,
  space,
  enter,
  keypad_enter,
  escape,
  a,
  c,
  v,
  x,
  y,
  z,
  count
};
enum class Button : uint8_t { left, right, middle };

// Positions are pixels of the image, from its upper left corner.
struct MouseMoved {
  glm::vec2 at_px{0};
};
struct MouseButton {
  Button button = Button::left;
  bool down = false;
};
struct MouseWheel {
  glm::vec2 steps{0};
};
struct KeyChanged {
  Key key = Key::none;
  bool down = false;
};
struct Text {
  char32_t character = 0;
};
struct MouseLeft {};  // the window
using Event = std::variant<MouseMoved, MouseButton, MouseWheel, KeyChanged, Text, MouseLeft>;

struct Input {
  glm::vec2 display_px{0};
  float scale = 1;    // of text and panels: 2 on a display with twice the density
  float delta_s = 0;  // since the last frame
  bool ctrl = false, shift = false, alt = false;
  std::vector<Event> events;  // since the last frame, in their order
};

// Where the mouse is, as panels want it seen.
enum class Cursor : uint8_t { arrow, text, resize_horizontal, resize_vertical, hand };

}  // namespace fire3dv::gui
