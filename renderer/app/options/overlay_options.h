// Overlay file of a run, as its options choose it.
#pragma once

#include "base/error.h"
#include "renderer/app/options/options.h"
#include "renderer/editing/edit_document.h"
#include "renderer/editing/edit_session.h"

namespace fire3dv::app {

// The file of --overlay, else SCENE.overlay.json. scene_is_file: false for the scene of a recording.
OverlayFile overlay_file(const Options& options, bool scene_is_file);

// Document of --overlay, with the variant of --variant in place of its own; empty without the options. With a
// window a missing file is no error: it is saved.
Result<state::EditDocument> load_overlay(const Options& options);

}  // namespace fire3dv::app
