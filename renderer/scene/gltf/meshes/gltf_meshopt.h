// EXT_meshopt_compression decoder for buffer views.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "protocol/base/error.h"
#include "renderer/scene/gltf/gltf_document.h"

namespace fire3dv::scene {

// Decodes each compressed buffer view into a new buffer and redirects the view to it. Later stages see plain
// buffer views and never read fallback buffers. Requires the document's buffers.
Result<void> decompress_buffer_views(nlohmann::json& root, const LoadLimits& limits, GltfDocument& document);

// True if the buffer is a fallback of the extension; its bytes may be missing.
bool is_meshopt_fallback(const nlohmann::json& buffer);

}  // namespace fire3dv::scene
