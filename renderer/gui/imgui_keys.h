// Key input of Dear ImGui, by the interface of the version that is installed: key events since 1.89, key
// arrays before.
#pragma once

#include <imgui.h>

#include "renderer/gui/input.h"

namespace fire3dv::gui {

// Once after the context is made. Events reach the next frame: the caller spreads them over frames itself.
void set_up_keys(ImGuiIO& io);
void set_key(ImGuiIO& io, Key key, bool down);
void set_modifiers(ImGuiIO& io, bool ctrl, bool shift, bool alt);

}  // namespace fire3dv::gui
