// glTF node hierarchy loader for the default scene, with lights and cameras.
#pragma once

#include <cstdint>
#include <vector>

#include "protocol/base/error.h"
#include "renderer/scene/gltf/gltf_document.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// Requires meshes. Nodes outside the default scene are omitted. Returns the scene node of each file node, or
// kNone.
Result<std::vector<uint32_t>> add_nodes(const GltfDocument& document, const LoadLimits& limits, Scene& scene);

}  // namespace fire3dv::scene
