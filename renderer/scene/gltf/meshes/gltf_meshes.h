// glTF mesh loader: triangle, line and point lists with all vertex attributes.
#pragma once

#include "protocol/base/error.h"
#include "renderer/scene/gltf/gltf_document.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// Requires the scene's materials.
Result<void> add_meshes(const GltfDocument& document, const LoadLimits& limits, const LoadProgress& progress,
                        Scene& scene);

}  // namespace fire3dv::scene
