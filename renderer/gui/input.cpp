#include "renderer/gui/input.h"

#include <imgui.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

namespace fire3dv::gui {
namespace {

constexpr std::pair<Key, int> kImguiKeys[] = {
    {Key::tab, ImGuiKey_Tab},
    {Key::left, ImGuiKey_LeftArrow},
    {Key::right, ImGuiKey_RightArrow},
    {Key::up, ImGuiKey_UpArrow},
    {Key::down, ImGuiKey_DownArrow},
    {Key::page_up, ImGuiKey_PageUp},
    {Key::page_down, ImGuiKey_PageDown},
    {Key::home, ImGuiKey_Home},
    {Key::end, ImGuiKey_End},
    {Key::insert, ImGuiKey_Insert},
    {Key::remove, ImGuiKey_Delete},
    {Key::backspace, ImGuiKey_Backspace},
    {Key::space, ImGuiKey_Space},
    {Key::enter, ImGuiKey_Enter},
    {Key::escape, ImGuiKey_Escape},
    {letter('a'), ImGuiKey_A},
    {letter('c'), ImGuiKey_C},
    {letter('v'), ImGuiKey_V},
    {letter('x'), ImGuiKey_X},
    {letter('y'), ImGuiKey_Y},
    {letter('z'), ImGuiKey_Z},
};

}  // namespace

#if IMGUI_VERSION_NUM >= 18900

void set_up_keys(ImGuiIO& io) {
  io.ConfigInputTrickleEventQueue = false;
}

void set_key(ImGuiIO& io, Key key, bool down) {
  const auto* const known = std::ranges::find(kImguiKeys, key, &std::pair<Key, int>::first);
  if (known != std::end(kImguiKeys)) io.AddKeyEvent(static_cast<ImGuiKey>(known->second), down);
}

void set_modifiers(ImGuiIO& io, const HeldKeys& held) {
  io.AddKeyEvent(ImGuiMod_Ctrl, held.ctrl);
  io.AddKeyEvent(ImGuiMod_Shift, held.shift);
  io.AddKeyEvent(ImGuiMod_Alt, held.alt);
}

#else

void set_up_keys(ImGuiIO& io) {
  for (const auto& [key, imgui_key] : kImguiKeys) io.KeyMap[imgui_key] = static_cast<int>(key);
}

void set_key(ImGuiIO& io, Key key, bool down) {
  if (key < Key::count) io.KeysDown[static_cast<size_t>(key)] = down;
}

void set_modifiers(ImGuiIO& io, const HeldKeys& held) {
  io.KeyCtrl = held.ctrl;
  io.KeyShift = held.shift;
  io.KeyAlt = held.alt;
}

#endif

}  // namespace fire3dv::gui
