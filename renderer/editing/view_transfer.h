// Selections and edits of the user: their transfer to another scene.
#pragma once

#include "renderer/editing/edit_document.h"
#include "renderer/editing/view_state.h"

namespace fire3dv::app {

// True if selections or edits name objects of the scene.
bool refers_to_scene(const ViewState& view_state);
// Transfers selections and edits to another scene by the keys of their objects (state::EditKey); drops those
// of objects that do not exist there. Lights need a file light of the same kind.
void transfer_by_key(ViewState& view_state, const state::EditTargets& before,
                     const state::EditTargets& after);

// Clears everything that refers to a scene, for an unrelated scene.
void forget_scene(ViewState& view_state);

}  // namespace fire3dv::app
