// Meshes: every primitive becomes a triangle list with all vertex attributes.
#pragma once

#include "protocol/error.h"
#include "renderer/scene/gltf_document.h"
#include "renderer/scene/scene.h"

namespace fire3dv::scene {

// The scene's materials are there already.
Result<void> add_meshes(const GltfDocument& document, const LoadLimits& limits, const LoadProgress& progress,
                        Scene& scene);

}  // namespace fire3dv::scene
