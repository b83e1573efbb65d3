// The layers that KHR_materials_* extensions put on a material.
#pragma once

#include "renderer/scene/gltf_textures.h"

namespace fire3dv::scene {

// Fills the fields of ior, specular, clearcoat, sheen, transmission and emissive_strength. Factors out of
// their range are brought into it with a warning.
Result<void> add_material_extensions(const tinygltf::Material& source, const std::string& where,
                                     Textures& textures, Material& material,
                                     std::vector<std::string>& warnings);

}  // namespace fire3dv::scene
