// Input events of a window in the order of their occurrence, and the key map from GLFW. Plain data,
// independent of a window.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <vector>

namespace fire3dv::sinks {

// Keys by their physical position on a US layout, so that W, A, S, D are in the same place on all keyboards.
enum class Key : uint8_t {
  other,
  digit_0,  // digits and letters are contiguous
  digit_1,
  digit_9 = digit_0 + 9,
  a,
  z = a + 25,
  f1,
  f12 = f1 + 11,
  space,
  escape,
  enter,
  tab,
  backspace,
  insert,
  remove,
  left,
  right,
  up,
  down,
  page_up,
  page_down,
  home,
  end,
  minus,
  equal,
  comma,
  period,
  left_shift,
  right_shift,
  left_control,
  right_control,
  left_alt,
  right_alt,
  left_super,
  right_super,
};

// Letter key; c is 'a' to 'z'.
constexpr Key letter(char c) {
  return static_cast<Key>(static_cast<int>(Key::a) + c - 'a');
}

enum class Button : uint8_t { left, right, middle };

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
