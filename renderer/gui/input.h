// Keys, keyboard and mouse events for panels, and their key input into Dear ImGui. Plain structs, filled by
// the window's owner or by a test.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <variant>
#include <vector>

struct ImGuiIO;

namespace fire3dv::gui {

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
  count
};

// Letter key; c is 'a' to 'z'.
constexpr Key letter(char c) {
  return static_cast<Key>(static_cast<int>(Key::a) + c - 'a');
}

enum class Button : uint8_t { left, right, middle };

// Positions are in image pixels from the upper left corner.
struct MouseMoved {
  glm::vec2 at_px{0};
};
struct HeldKeys {
  bool ctrl = false, shift = false, alt = false;
  bool operator==(const HeldKeys&) const = default;
};
struct MouseButton {
  Button button = Button::left;
  bool down = false;
  HeldKeys held = {};
};
struct MouseWheel {
  glm::vec2 steps{0};
};
struct KeyChanged {
  Key key = Key::other;
  bool down = false, repeated = false;
  HeldKeys held = {};
};
struct Text {
  char32_t character = 0;
};
struct MouseLeft {};  // left the window
using Event = std::variant<MouseMoved, MouseButton, MouseWheel, KeyChanged, Text, MouseLeft>;

struct Input {
  glm::vec2 display_px{0};
  float scale = 1;            // UI scale: 2 on a display with twice the density
  float delta_s = 0;          // since the last frame
  HeldKeys held;              // after the events
  std::vector<Event> events;  // since the last frame, in order
};

// Requested mouse cursor.
enum class Cursor : uint8_t { arrow, text, resize_horizontal, resize_vertical, hand };

// Key input of Dear ImGui for the installed version: key events since 1.89, key arrays before.
// Call set_up_keys() once after the context is created. Disables ImGui's event trickling: the caller spreads
// events over frames.
void set_up_keys(ImGuiIO& io);
// Ignores keys that no widget handles; text arrives as Text events.
void set_key(ImGuiIO& io, Key key, bool down);
void set_modifiers(ImGuiIO& io, const HeldKeys& held);

}  // namespace fire3dv::gui
