#include "renderer/passes/material_records.h"

#include <algorithm>
#include <cmath>

namespace fire3dv::passes {
namespace {

gpu_types::TextureUse texture_use(const scene::TextureRef& ref) {
  // KHR_texture_transform: uv' = translate(offset) * rotate * scale(uv), with the extension's sense of rotation.
  const float c = std::cos(ref.uv_rotation_rad);
  const float s = std::sin(ref.uv_rotation_rad);
  gpu_types::TextureUse use{};
  use.texture = ref.texture;
  use.uv_set = ref.uv_set;
  use.uv_rows = {c * ref.uv_scale.x, s * ref.uv_scale.y, -s * ref.uv_scale.x, c * ref.uv_scale.y};
  use.uv_offset = ref.uv_offset;
  return use;
}

}  // namespace

gpu_types::MaterialRecord material_record(const scene::Material& material) {
  gpu_types::MaterialRecord record{};
  record.base_color = material.base_color;
  record.emissive = material.emissive;
  record.metallic = material.metallic;
  record.roughness = material.roughness;
  record.normal_scale = material.normal_scale;
  record.occlusion_strength = material.occlusion_strength;
  record.alpha_cutoff = material.alpha_cutoff;
  record.flags = (material.double_sided ? FIRE3DV_MATERIAL_DOUBLE_SIDED : 0) |
                 (material.unlit ? FIRE3DV_MATERIAL_UNLIT : 0) |
                 (material.alpha_mode == scene::AlphaMode::mask ? FIRE3DV_MATERIAL_MASK : 0) |
                 (material.alpha_mode == scene::AlphaMode::blend ? FIRE3DV_MATERIAL_BLEND : 0);
  record.base_color_texture = texture_use(material.base_color_texture);
  record.metallic_roughness_texture = texture_use(material.metallic_roughness_texture);
  record.normal_texture = texture_use(material.normal_texture);
  record.occlusion_texture = texture_use(material.occlusion_texture);
  record.emissive_texture = texture_use(material.emissive_texture);
  return record;
}

gpu_types::LightRecord light_record(const scene::Light& light, uint32_t node) {
  gpu_types::LightRecord record{};
  record.color = light.color * light.intensity;
  record.range_m = light.range_m;
  record.node = node;
  record.radius_m = light.radius_m;
  record.angular_radius_rad = light.angular_radius_rad;
  switch (light.type) {
    case scene::LightType::directional: record.type = FIRE3DV_LIGHT_DIRECTIONAL; break;
    case scene::LightType::point: record.type = FIRE3DV_LIGHT_POINT; break;
    case scene::LightType::spot: record.type = FIRE3DV_LIGHT_SPOT; break;
  }
  // The formula of KHR_lights_punctual, "Inner and Outer Cone Angles".
  const float cos_outer = std::cos(light.outer_cone_rad);
  record.cone_scale = 1.0f / std::max(0.001f, std::cos(light.inner_cone_rad) - cos_outer);
  record.cone_offset = -cos_outer * record.cone_scale;
  return record;
}

}  // namespace fire3dv::passes
