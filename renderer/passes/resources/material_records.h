// GPU records of materials and lights.
#pragma once

#include <span>
#include <vector>

#include "renderer/scene/model/scene.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

struct MaterialRecords {
  std::vector<gpu_types::MaterialRecord> materials;
  std::vector<gpu_types::MaterialExtensionRecord> extensions;  // of materials with extensions
};
bool any_extended(std::span<const scene::Material> materials);
bool any_textured(std::span<const scene::Material> materials);
bool any_second_uv(std::span<const scene::Material> materials);  // true if a texture uses it
// Facts about textures that material records contain.
struct TextureFacts {
  std::vector<glm::uvec2> sizes;  // by texture index; missing entries count as one texel
  bool anisotropic = false;       // smooth samplers filter anisotropically
};
TextureFacts texture_facts(const scene::Scene& scene, bool anisotropic);
MaterialRecords material_records(std::span<const scene::Material> materials,
                                 const TextureFacts& textures = {});
gpu_types::LightRecord light_record(const scene::Light& light, uint32_t node);

}  // namespace fire3dv::passes
