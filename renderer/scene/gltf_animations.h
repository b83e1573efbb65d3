// Animations: which node's part follows which keys.
#pragma once

#include <cstdint>
#include <span>

#include "renderer/scene/gltf_accessors.h"

namespace fire3dv::scene {

// After nodes and morph weights. node_of_source: the scene's node of each of the file's, or kNone.
Result<void> add_animations(const GltfDocument& document, const LoadLimits& limits,
                            std::span<const uint32_t> node_of_source, Scene& scene);

}  // namespace fire3dv::scene
