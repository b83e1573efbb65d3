// Loader of the KHR_materials_* extensions.
#pragma once

#include "renderer/scene/gltf/materials/gltf_textures.h"

namespace fire3dv::scene {

// Reads ior, specular, clearcoat, sheen, transmission and emissive_strength. Out-of-range factors are clamped
// with a warning.
Result<void> add_material_extensions(const tinygltf::Material& source, const std::string& where,
                                     Textures& textures, Material& material,
                                     std::vector<std::string>& warnings);

}  // namespace fire3dv::scene
