// Materials, and the textures and images that they use.
#pragma once

#include <cstdint>
#include <vector>

#include "protocol/error.h"
#include "renderer/scene/gltf_document.h"
#include "renderer/scene/scene.h"

namespace fire3dv::scene {

// Appends materials (after glTF's default one) and textures. Texture::image indexes the returned list of
// images of the file: only those that are used are decoded.
Result<std::vector<uint32_t>> add_materials(const GltfDocument& document, Scene& scene);

}  // namespace fire3dv::scene
