#include "renderer/gui/input.h"

#include <imgui.h>

#include <cstddef>

namespace fire3dv::gui {
namespace {

// ImGui keys in the order of Key; 1.89 renamed one.
#if IMGUI_VERSION_NUM >= 18900
constexpr int kKeypadEnter = ImGuiKey_KeypadEnter;
#else
constexpr int kKeypadEnter = ImGuiKey_KeyPadEnter;
#endif
constexpr int kImguiKeys[] = {
    -1,
    ImGuiKey_Tab,
    ImGuiKey_LeftArrow,
    ImGuiKey_RightArrow,
    ImGuiKey_UpArrow,
    ImGuiKey_DownArrow,
    ImGuiKey_PageUp,
    ImGuiKey_PageDown,
    ImGuiKey_Home,
    ImGuiKey_End,
    ImGuiKey_Insert,
    ImGuiKey_Delete,
    ImGuiKey_Backspace,
    ImGuiKey_Space,
    ImGuiKey_Enter,
    kKeypadEnter,
    ImGuiKey_Escape,
    ImGuiKey_A,
    ImGuiKey_C,
    ImGuiKey_V,
    ImGuiKey_X,
    ImGuiKey_Y,
    ImGuiKey_Z,
};
constexpr auto kKeyCount = static_cast<size_t>(Key::count);
static_assert(sizeof kImguiKeys / sizeof *kImguiKeys == kKeyCount);

}  // namespace

#if IMGUI_VERSION_NUM >= 18900

void set_up_keys(ImGuiIO& io) {
  io.ConfigInputTrickleEventQueue = false;
}

void set_key(ImGuiIO& io, Key key, bool down) {
  if (key == Key::none || key >= Key::count) return;
  io.AddKeyEvent(static_cast<ImGuiKey>(kImguiKeys[static_cast<size_t>(key)]), down);
}

void set_modifiers(ImGuiIO& io, bool ctrl, bool shift, bool alt) {
  io.AddKeyEvent(ImGuiMod_Ctrl, ctrl);
  io.AddKeyEvent(ImGuiMod_Shift, shift);
  io.AddKeyEvent(ImGuiMod_Alt, alt);
}

#else

void set_up_keys(ImGuiIO& io) {
  for (size_t i = 1; i < kKeyCount; ++i) io.KeyMap[kImguiKeys[i]] = static_cast<int>(i);
}

void set_key(ImGuiIO& io, Key key, bool down) {
  if (key < Key::count) io.KeysDown[static_cast<size_t>(key)] = down;
}

void set_modifiers(ImGuiIO& io, bool ctrl, bool shift, bool alt) {
  io.KeyCtrl = ctrl;
  io.KeyShift = shift;
  io.KeyAlt = alt;
}

#endif

}  // namespace fire3dv::gui
