// What the user did in a window, in the order in which it was done. Plain data: neither making nor reading it
// takes a window.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <vector>

namespace fire3dv::sinks {

// By their places on a US keyboard: W, A, S, D lie as a hand does on every one.
enum class Key : uint8_t {
  other,
  digit_0,  // digits and letters follow one another
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
  left_shift,
  right_shift,
  left_control,
  right_control,
  left_alt,
  right_alt,
  left_super,
  right_super,
};

// 'a' to 'z'.
constexpr Key letter(char c) {
  return static_cast<Key>(static_cast<int>(Key::a) + c - 'a');
}

enum class Button : uint8_t { left, right, middle };

struct Modifiers {
  bool shift = false, control = false, alt = false, super = false;
};

struct InputEvent {
  enum class Kind : uint8_t {
    move,    // of the cursor
    button,  // went down or up
    wheel,
    key,    // went down or up, or is repeated while it is down
    text,   // a character was typed
    focus,  // came (down) or went
    leave,  // the cursor is outside
  };
  Kind kind = Kind::move;
  Modifiers modifiers;
  glm::vec2 cursor_px{0};  // in pixels of the image, from its top left corner
  glm::vec2 wheel{0};      // to the right and up, in notches
  Button button = Button::left;
  Key key = Key::other;
  bool down = false, repeated = false;
  char32_t text = 0;
};

struct WindowInput {
  std::vector<InputEvent> events;
  std::vector<std::filesystem::path> dropped;  // files that were dragged here
  float scale = 1;                             // pixels of the image for one of a display of usual density
};

}  // namespace fire3dv::sinks
