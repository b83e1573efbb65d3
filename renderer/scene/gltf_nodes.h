// The node hierarchy of the scene that is shown, with its lights and cameras.
#pragma once

#include <cstdint>
#include <vector>

#include "protocol/error.h"
#include "renderer/scene/gltf_document.h"
#include "renderer/scene/scene.h"

namespace fire3dv::scene {

// Meshes are there already. Nodes outside the default scene are left out. Returns the scene's node of each of
// the file's, or kNone.
Result<std::vector<uint32_t>> add_nodes(const GltfDocument& document, const LoadLimits& limits, Scene& scene);

}  // namespace fire3dv::scene
