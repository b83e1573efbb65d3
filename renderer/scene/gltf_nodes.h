// The node hierarchy of the scene that is shown, with its lights and cameras.
#pragma once

#include "protocol/error.h"
#include "renderer/scene/gltf_document.h"
#include "renderer/scene/scene.h"

namespace fire3dv::scene {

// Meshes are there already. Nodes outside the default scene are left out.
Result<void> add_nodes(const GltfDocument& document, const LoadLimits& limits, Scene& scene);

}  // namespace fire3dv::scene
