// Digest of the asset files that a document of edits adds to its scene.
#pragma once

#include <functional>
#include <string>

#include "renderer/editing/edit_document.h"
#include "renderer/live_scene/asset_files.h"

namespace fire3dv::app {

// Digest of the contents of all assets that a document adds, with the files that they name; empty: it adds
// none. A missing or damaged one counts by its error. Loads them one after the other; should_stop: ends that,
// and the result is of no use.
std::string digest_of_assets(const state::EditDocument& document, const AssetFiles& files,
                             const std::function<bool()>& should_stop);

}  // namespace fire3dv::app
