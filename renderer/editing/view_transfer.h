// Selections and edits of the viewer: their transfer to another scene.
#pragma once

#include "renderer/editing/edit_document.h"
#include "renderer/gui/panel_data.h"

namespace fire3dv::app {

// True if selections or edits name objects of the scene.
bool refers_to_scene(const gui::ViewState& viewer);
// Transfers selections and edits to another scene by the keys of their objects (state::EditKey); drops those
// of objects that do not exist there. Lights need a file light of the same kind.
void transfer_by_key(gui::ViewState& viewer, const state::EditTargets& before,
                     const state::EditTargets& after);

// Clears everything that refers to a scene, for an unrelated scene.
void forget_scene(gui::ViewState& viewer);

}  // namespace fire3dv::app
