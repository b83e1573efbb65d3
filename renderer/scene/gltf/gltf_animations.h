// glTF animation loader: channels and their key frames.
#pragma once

#include <cstdint>
#include <span>

#include "renderer/scene/gltf/meshes/gltf_accessors.h"

namespace fire3dv::scene {

// Requires nodes and morph weights. node_of_source: scene node of each file node, or kNone.
Result<void> add_animations(const GltfDocument& document, const LoadLimits& limits,
                            std::span<const uint32_t> node_of_source, Scene& scene);

}  // namespace fire3dv::scene
