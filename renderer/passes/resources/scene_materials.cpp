#include "renderer/passes/resources/scene_materials.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <glm/gtc/packing.hpp>

#include "renderer/scene/model/scene_fields.h"
#include "renderer/scene/textures/images.h"

namespace fire3dv::passes {
namespace {

// Packs a size as halves: above 2048 the error is at most one in 2048, which is less than a thousandth of a
// mip level.
uint32_t packed_size(uint32_t texture, const TextureFacts& textures) {
  constexpr float kMaxOfAHalf = 65504;
  const glm::vec2 size = texture < textures.sizes.size() ? glm::vec2(textures.sizes[texture]) : glm::vec2(1);
  return glm::packHalf2x16(glm::min(size, kMaxOfAHalf));
}

gpu_types::TextureUse texture_use(const scene::TextureRef& ref, const TextureFacts& textures) {
  // KHR_texture_transform: uv' = translate(offset) * rotate * scale(uv), with the extension's direction of
  // rotation.
  const float c = std::cos(ref.uv_rotation_rad);
  const float s = std::sin(ref.uv_rotation_rad);
  gpu_types::TextureUse use{};
  use.texture = ref.texture;
  use.size = packed_size(ref.texture, textures);
  if (ref.texture != scene::kNone && ref.uv_set != 0) use.texture |= FIRE3DV_TEXTURE_SECOND_UV;
  if (ref.texture != scene::kNone && textures.anisotropic) use.texture |= FIRE3DV_TEXTURE_ANISOTROPIC;
  use.uv_rows = {c * ref.uv_scale.x, s * ref.uv_scale.y, -s * ref.uv_scale.x, c * ref.uv_scale.y};
  use.uv_offset = ref.uv_offset;
  return use;
}

// Coefficient of the Beer-Lambert law: light keeps attenuation_color after attenuation_distance_m.
glm::vec3 absorption_per_m(const scene::Material& material) {
  if (material.attenuation_distance_m == 0) return glm::vec3(0);
  constexpr float kOpaque = 1e30f;
  glm::vec3 absorption;
  for (int c = 0; c < 3; ++c) {
    const float color = material.attenuation_color[c];
    absorption[c] =
        color > 0 ? std::clamp(-std::log(color) / material.attenuation_distance_m, 0.0f, kOpaque) : kOpaque;
  }
  return absorption;
}

uint32_t extension_flags(const scene::Material& material) {
  if (material.unlit) return 0;
  return (material.transmission > 0 ? FIRE3DV_MATERIAL_TRANSMISSION : 0) |
         (scene::is_volume(material) ? FIRE3DV_MATERIAL_VOLUME : 0) |
         (scene::is_volume(material) && material.dispersion > 0 ? FIRE3DV_MATERIAL_DISPERSION : 0) |
         (material.diffuse_transmission > 0 ? FIRE3DV_MATERIAL_DIFFUSE_TRANSMISSION : 0) |
         (material.sheen_color != glm::vec3(0) ? FIRE3DV_MATERIAL_SHEEN : 0) |
         (material.clearcoat > 0 ? FIRE3DV_MATERIAL_CLEARCOAT : 0) |
         (material.anisotropy > 0 ? FIRE3DV_MATERIAL_ANISOTROPY : 0) |
         (material.iridescence > 0 ? FIRE3DV_MATERIAL_IRIDESCENCE : 0);
}

// Vertex attributes that the material's textures need.
uint32_t texture_flags(const scene::Material& material) {
  uint32_t flags = 0;
  scene::visit_textures(material, [&](const scene::TextureRef& texture) {
    if (texture.texture == scene::kNone) return;
    flags |= FIRE3DV_MATERIAL_TEXTURED;
    if (texture.uv_set != 0) flags |= FIRE3DV_MATERIAL_SECOND_UV;
  });
  if (scene::needs_tangents(material)) {
    flags |= FIRE3DV_MATERIAL_NORMAL_MAPPED;
  }
  return flags;
}

bool is_extended(const scene::Material& material) {
  const scene::Material core;
  return !material.unlit &&
         (extension_flags(material) || material.ior != core.ior || material.specular != core.specular ||
          material.specular_color != core.specular_color ||
          material.specular_texture.texture != scene::kNone ||
          material.specular_color_texture.texture != scene::kNone);
}

gpu_types::MaterialExtensionRecord extension_record(const scene::Material& material,
                                                    const TextureFacts& textures) {
  gpu_types::MaterialExtensionRecord record{};
  const float ratio = (material.ior - 1) / (material.ior + 1);
  record.dielectric_f0 = ratio * ratio * material.specular_color;
  record.specular = material.specular;
  record.sheen_color = material.sheen_color;
  record.sheen_roughness = material.sheen_roughness;
  record.anisotropy = material.anisotropy;
  record.anisotropy_direction = {std::cos(material.anisotropy_rotation_rad),
                                 std::sin(material.anisotropy_rotation_rad)};
  record.iridescence = material.iridescence;
  record.iridescence_ior = material.iridescence_ior;
  record.iridescence_thickness_nm = {material.iridescence_thickness_min_nm,
                                     material.iridescence_thickness_max_nm};
  record.clearcoat = material.clearcoat;
  record.clearcoat_roughness = material.clearcoat_roughness;
  record.clearcoat_normal_scale = material.clearcoat_normal_scale;
  record.transmission = material.transmission;
  record.absorption_per_m = absorption_per_m(material);
  record.ior = material.ior;
  record.dispersion = material.dispersion;
  record.diffuse_transmission = material.diffuse_transmission;
  record.diffuse_transmission_color = material.diffuse_transmission_color;
  record.diffuse_transmission_texture = texture_use(material.diffuse_transmission_texture, textures);
  record.diffuse_transmission_color_texture =
      texture_use(material.diffuse_transmission_color_texture, textures);
  record.specular_texture = texture_use(material.specular_texture, textures);
  record.specular_color_texture = texture_use(material.specular_color_texture, textures);
  record.clearcoat_texture = texture_use(material.clearcoat_texture, textures);
  record.clearcoat_roughness_texture = texture_use(material.clearcoat_roughness_texture, textures);
  record.clearcoat_normal_texture = texture_use(material.clearcoat_normal_texture, textures);
  record.sheen_color_texture = texture_use(material.sheen_color_texture, textures);
  record.sheen_roughness_texture = texture_use(material.sheen_roughness_texture, textures);
  record.anisotropy_texture = texture_use(material.anisotropy_texture, textures);
  record.iridescence_texture = texture_use(material.iridescence_texture, textures);
  record.iridescence_thickness_texture = texture_use(material.iridescence_thickness_texture, textures);
  record.transmission_texture = texture_use(material.transmission_texture, textures);
  return record;
}

gpu_types::MaterialRecord material_record(const scene::Material& material, const TextureFacts& textures) {
  gpu_types::MaterialRecord record{};
  record.base_color = material.base_color;
  record.emissive = material.emissive;
  record.metallic = material.metallic;
  record.roughness = material.roughness;
  record.normal_scale = material.normal_scale;
  record.occlusion_strength = material.occlusion_strength;
  // Values at the cutoff pass the alpha test despite rounding by interpolation and filtering. A step of an
  // 8-bit texture is forty times as large.
  constexpr float kRounding = 1e-4f;
  record.alpha_cutoff = material.alpha_cutoff - kRounding;
  record.flags = (material.double_sided ? FIRE3DV_MATERIAL_DOUBLE_SIDED : 0) |
                 (material.unlit ? FIRE3DV_MATERIAL_UNLIT : 0) |
                 (material.alpha_mode == scene::AlphaMode::mask ? FIRE3DV_MATERIAL_MASK : 0) |
                 (material.alpha_mode == scene::AlphaMode::blend ? FIRE3DV_MATERIAL_BLEND : 0);
  record.flags |= extension_flags(material) | texture_flags(material);
  record.extension = FIRE3DV_NO_INDEX;
  record.thickness = material.thickness;
  record.base_color_texture = texture_use(material.base_color_texture, textures);
  record.metallic_roughness_texture = texture_use(material.metallic_roughness_texture, textures);
  record.normal_texture = texture_use(material.normal_texture, textures);
  record.occlusion_texture = texture_use(material.occlusion_texture, textures);
  record.emissive_texture = texture_use(material.emissive_texture, textures);
  return record;
}

constexpr size_t kChunkBytes = size_t{16} << 20;

VkSamplerAddressMode address_mode(scene::Wrap wrap) {
  switch (wrap) {
    case scene::Wrap::repeat:
      return VK_SAMPLER_ADDRESS_MODE_REPEAT;
    case scene::Wrap::mirrored_repeat:
      return VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT;
    case scene::Wrap::clamp_to_edge:
      return VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  }
  return VK_SAMPLER_ADDRESS_MODE_REPEAT;
}

gpu::Sampler create_sampler(gpu::Device& device, const scene::Sampler& wanted, float anisotropy) {
  VkSamplerCreateInfo info{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
  info.magFilter = wanted.nearest_mag ? VK_FILTER_NEAREST : VK_FILTER_LINEAR;
  info.minFilter = wanted.nearest_min ? VK_FILTER_NEAREST : VK_FILTER_LINEAR;
  info.mipmapMode = wanted.nearest_mip ? VK_SAMPLER_MIPMAP_MODE_NEAREST : VK_SAMPLER_MIPMAP_MODE_LINEAR;
  info.addressModeU = address_mode(wanted.wrap_u);
  info.addressModeV = address_mode(wanted.wrap_v);
  info.addressModeW = VK_SAMPLER_ADDRESS_MODE_REPEAT;
  info.maxLod = wanted.use_mips ? VK_LOD_CLAMP_NONE : 0.25f;
  const bool smooth = !wanted.nearest_mag && !wanted.nearest_min && wanted.use_mips;
  if (smooth && anisotropy > 1 && device.report().anisotropy) {
    info.anisotropyEnable = VK_TRUE;
    info.maxAnisotropy = std::min(anisotropy, device.limits().maxSamplerAnisotropy);
  }
  VkSampler sampler = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateSampler(device.handle(), &info, nullptr, &sampler));
  return gpu::Sampler(device, sampler);
}

}  // namespace

bool any_extended(std::span<const scene::Material> materials) {
  return std::any_of(materials.begin(), materials.end(), is_extended);
}

bool any_textured(std::span<const scene::Material> materials) {
  return std::any_of(materials.begin(), materials.end(),
                     [](const scene::Material& material) { return texture_flags(material) != 0; });
}

bool any_second_uv(std::span<const scene::Material> materials) {
  return std::any_of(materials.begin(), materials.end(), [](const scene::Material& material) {
    return (texture_flags(material) & FIRE3DV_MATERIAL_SECOND_UV) != 0;
  });
}

uint32_t optional_flags(std::span<const scene::Material> materials) {
  uint32_t flags = 0;
  for (const scene::Material& material : materials) flags |= extension_flags(material);
  return flags & FIRE3DV_MATERIAL_OPTIONAL;
}

TextureFacts texture_facts(const scene::Scene& scene, bool anisotropic) {
  TextureFacts facts;
  facts.anisotropic = anisotropic;
  for (const scene::Texture& texture : scene.textures) {
    const scene::Image& image = scene.images[texture.image];
    facts.sizes.emplace_back(image.width, image.height);
  }
  return facts;
}

MaterialRecords material_records(std::span<const scene::Material> materials, const TextureFacts& textures) {
  MaterialRecords records;
  for (const scene::Material& material : materials) {
    records.materials.push_back(material_record(material, textures));
    if (!is_extended(material)) continue;
    records.materials.back().extension = static_cast<uint32_t>(records.extensions.size());
    records.extensions.push_back(extension_record(material, textures));
  }
  return records;
}

gpu_types::LightRecord light_record(const scene::Light& light, uint32_t node) {
  gpu_types::LightRecord record{};
  record.color = light.color * light.intensity;
  record.range_m = light.range_m;
  record.node = node;
  record.radius_m = light.radius_m;
  record.angular_radius_rad = light.angular_radius_rad;
  switch (light.type) {
    case scene::LightType::directional:
      record.type = FIRE3DV_LIGHT_DIRECTIONAL;
      break;
    case scene::LightType::point:
      record.type = FIRE3DV_LIGHT_POINT;
      break;
    case scene::LightType::spot:
      record.type = FIRE3DV_LIGHT_SPOT;
      break;
  }
  // Formula of KHR_lights_punctual, "Inner and Outer Cone Angles".
  const float cos_outer = std::cos(light.outer_cone_rad);
  record.cone_scale = 1.0f / std::max(0.001f, std::cos(light.inner_cone_rad) - cos_outer);
  record.cone_offset = -cos_outer * record.cone_scale;
  if (light.type == scene::LightType::point && light.spread > 0) {
    record.type = FIRE3DV_LIGHT_LAMP;
    record.cone_scale = light.spread;
  }
  return record;
}

VkSampler TextureUploads::sampler_of(const scene::Sampler& wanted) {
  const auto known = std::find_if(samplers_.begin(), samplers_.end(),
                                  [&](const auto& sampler) { return sampler.first == wanted; });
  if (known != samplers_.end()) return known->second;
  uploaded_.samplers.push_back(create_sampler(device_, wanted, anisotropy_));
  return samplers_.emplace_back(wanted, uploaded_.samplers.back().get()).second;
}

TextureUploads::TextureUploads(gpu::Device& device, const scene::Scene& scene, float anisotropy,
                               const SceneTextures* before)
    : device_(device), scene_(scene), anisotropy_(anisotropy), loader_(device) {
  if (!before) return;
  for (const SharedTexture& texture : before->images) {
    // Pixels that are gone may have left their address to others.
    if (const std::shared_ptr<const void> pixels = texture.pixels.lock())
      known_[{pixels.get(), texture.srgb}] = texture.image;
  }
}

void TextureUploads::add(const scene::Texture& texture) {
  VkImageView& view = views_[{texture.image, texture.srgb}];
  if (!view) {
    const scene::Image& source = scene_.images[texture.image];
    const std::shared_ptr<const void> pixels = source.rgba8.identity();
    const auto known = known_.find({pixels.get(), texture.srgb});
    const std::shared_ptr<gpu::Image> image =
        pixels && known != known_.end() ? known->second : upload(source, texture.srgb);
    if (pixels) known_[{pixels.get(), texture.srgb}] = image;  // several images may share their pixels
    uploaded_.images.push_back({pixels, texture.srgb, image});
    view = image->view.get();
  }
  uploaded_.sampled.push_back({view, sampler_of(texture.sampler)});
}

std::shared_ptr<gpu::Image> TextureUploads::upload(const scene::Image& source, bool srgb) {
  gpu::ImageInfo info;
  info.format = srgb ? VK_FORMAT_R8G8B8A8_SRGB : VK_FORMAT_R8G8B8A8_UNORM;
  info.extent = {source.width, source.height};
  info.mip_levels = static_cast<uint32_t>(std::bit_width(std::max(source.width, source.height)));
  info.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  auto image = std::make_shared<gpu::Image>(gpu::create_image(device_, info));
  const std::vector<std::vector<uint8_t>> smaller = scene::generate_mip_levels(source, srgb);
  std::vector<std::span<const std::byte>> levels{std::as_bytes(std::span(source.rgba8))};
  for (const std::vector<uint8_t>& level : smaller) levels.push_back(std::as_bytes(std::span(level)));
  loader_.upload_levels(*image, levels);
  chunk_bytes_ += source.rgba8.size();
  return image;
}

void TextureUploads::submit_some() {
  chunk_bytes_ = 0;
  while (next_ < scene_.textures.size() && chunk_bytes_ < kChunkBytes) add(scene_.textures[next_++]);
  loader_.submit();
}

SceneTextures TextureUploads::finish() {
  while (next_ < scene_.textures.size()) submit_some();
  loader_.finish();
  return std::move(uploaded_);
}

}  // namespace fire3dv::passes
