#include "renderer/window/window_input.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace fire3dv::sinks {

Key key_of(int glfw_key) {
  const auto at = [&](Key first, int glfw_first) {
    return static_cast<Key>(static_cast<int>(first) + glfw_key - glfw_first);
  };
  if (glfw_key >= GLFW_KEY_0 && glfw_key <= GLFW_KEY_9) return at(Key::digit_0, GLFW_KEY_0);
  if (glfw_key >= GLFW_KEY_KP_0 && glfw_key <= GLFW_KEY_KP_9) return at(Key::digit_0, GLFW_KEY_KP_0);
  if (glfw_key >= GLFW_KEY_A && glfw_key <= GLFW_KEY_Z) return at(Key::a, GLFW_KEY_A);
  if (glfw_key >= GLFW_KEY_F1 && glfw_key <= GLFW_KEY_F12) return at(Key::f1, GLFW_KEY_F1);
  switch (glfw_key) {
    case GLFW_KEY_SPACE:
      return Key::space;
    case GLFW_KEY_ESCAPE:
      return Key::escape;
    case GLFW_KEY_ENTER:
    case GLFW_KEY_KP_ENTER:
      return Key::enter;
    case GLFW_KEY_TAB:
      return Key::tab;
    case GLFW_KEY_BACKSPACE:
      return Key::backspace;
    case GLFW_KEY_INSERT:
      return Key::insert;
    case GLFW_KEY_DELETE:
      return Key::remove;
    case GLFW_KEY_LEFT:
      return Key::left;
    case GLFW_KEY_RIGHT:
      return Key::right;
    case GLFW_KEY_UP:
      return Key::up;
    case GLFW_KEY_DOWN:
      return Key::down;
    case GLFW_KEY_PAGE_UP:
      return Key::page_up;
    case GLFW_KEY_PAGE_DOWN:
      return Key::page_down;
    case GLFW_KEY_HOME:
      return Key::home;
    case GLFW_KEY_END:
      return Key::end;
    case GLFW_KEY_MINUS:
    case GLFW_KEY_KP_SUBTRACT:
      return Key::minus;
    case GLFW_KEY_EQUAL:
    case GLFW_KEY_KP_ADD:
      return Key::equal;
    case GLFW_KEY_COMMA:
      return Key::comma;
    case GLFW_KEY_PERIOD:
      return Key::period;
    case GLFW_KEY_LEFT_SHIFT:
      return Key::left_shift;
    case GLFW_KEY_RIGHT_SHIFT:
      return Key::right_shift;
    case GLFW_KEY_LEFT_CONTROL:
      return Key::left_control;
    case GLFW_KEY_RIGHT_CONTROL:
      return Key::right_control;
    case GLFW_KEY_LEFT_ALT:
      return Key::left_alt;
    case GLFW_KEY_RIGHT_ALT:
      return Key::right_alt;
    case GLFW_KEY_LEFT_SUPER:
      return Key::left_super;
    case GLFW_KEY_RIGHT_SUPER:
      return Key::right_super;
    default:
      return Key::other;
  }
}

}  // namespace fire3dv::sinks
