// Key input of Dear ImGui for the installed version: key events since 1.89, key arrays before.
#pragma once

#include <imgui.h>

#include "renderer/gui/input.h"

namespace fire3dv::gui {

// Call once after the context is created. Disables ImGui's event trickling: the caller spreads events over
// frames.
void set_up_keys(ImGuiIO& io);
void set_key(ImGuiIO& io, Key key, bool down);
void set_modifiers(ImGuiIO& io, bool ctrl, bool shift, bool alt);

}  // namespace fire3dv::gui
