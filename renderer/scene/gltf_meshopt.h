// EXT_meshopt_compression: buffer views whose bytes are compressed.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "protocol/error.h"
#include "renderer/scene/gltf_document.h"

namespace fire3dv::scene {

// Decodes each compressed buffer view into a buffer of its own and lets the view look there: nobody after
// this sees the extension, and fallback buffers are never read. The document's buffers are there already.
Result<void> decompress_buffer_views(nlohmann::json& root, const LoadLimits& limits, GltfDocument& document);

// Whether the buffer only stands in for what the extension holds, so that its own bytes need not exist.
bool is_meshopt_fallback(const nlohmann::json& buffer);

}  // namespace fire3dv::scene
