// Materials and lights as the shaders read them.
#pragma once

#include <span>
#include <vector>

#include "renderer/scene/scene.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

struct MaterialRecords {
  std::vector<gpu_types::MaterialRecord> materials;
  std::vector<gpu_types::MaterialExtensionRecord> extensions;  // of those that have any
};
bool any_extended(std::span<const scene::Material> materials);
bool any_textured(std::span<const scene::Material> materials);
bool any_second_uv(std::span<const scene::Material> materials);  // by a texture
// What a record says of the textures that a material refers to.
struct TextureFacts {
  std::vector<glm::uvec2> sizes;  // by number; where there is none a texture counts as one texel
  bool anisotropic = false;       // samplers that are smooth filter so
};
TextureFacts texture_facts(const scene::Scene& scene, bool anisotropic);
MaterialRecords material_records(std::span<const scene::Material> materials,
                                 const TextureFacts& textures = {});
gpu_types::LightRecord light_record(const scene::Light& light, uint32_t node);

}  // namespace fire3dv::passes
