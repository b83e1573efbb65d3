// Loaders of the parts of a glTF document, in the order in which load_gltf() calls them. Each has a source
// file of its name.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "protocol/base/error.h"
#include "renderer/scene/gltf/gltf_document.h"
#include "renderer/scene/gltf/meshes/gltf_accessors.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// Validates all indices of the file, including those of unused objects.
Result<void> check_references(const GltfDocument& document);

// Appends materials (after glTF's default material) and textures. Returns the used images of the file, which
// Texture::image indexes; unused images are not decoded.
Result<std::vector<uint32_t>> add_materials(const GltfDocument& document, Scene& scene);

// Requires the scene's materials.
Result<void> add_meshes(const GltfDocument& document, const LoadLimits& limits, const LoadProgress& progress,
                        Scene& scene);

// Requires meshes. Nodes outside the default scene are omitted. Returns the scene node of each file node, or
// kNone.
Result<std::vector<uint32_t>> add_nodes(const GltfDocument& document, const LoadLimits& limits, Scene& scene);

// KHR_lights_punctual lights and glTF cameras, in file order.
Result<void> add_lights(const GltfDocument& document, Scene& scene);
Result<void> add_cameras(const GltfDocument& document, Scene& scene);

// Requires nodes and morph weights. node_of_source: scene node of each file node, or kNone.
Result<void> add_animations(const GltfDocument& document, const LoadLimits& limits,
                            std::span<const uint32_t> node_of_source, Scene& scene);

}  // namespace fire3dv::scene
