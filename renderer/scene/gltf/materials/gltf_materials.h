// glTF material loader, with the textures and images in use.
#pragma once

#include <cstdint>
#include <vector>

#include "protocol/base/error.h"
#include "renderer/scene/gltf/gltf_document.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// Appends materials (after glTF's default material) and textures. Returns the used images of the file, which
// Texture::image indexes; unused images are not decoded.
Result<std::vector<uint32_t>> add_materials(const GltfDocument& document, Scene& scene);

}  // namespace fire3dv::scene
