#include "renderer/scene/gltf/materials/gltf_materials.h"

#include "renderer/scene/gltf/gltf_values.h"
#include "renderer/scene/gltf/materials/gltf_material_extensions.h"
#include "renderer/scene/gltf/materials/gltf_textures.h"

namespace fire3dv::scene {
namespace {

Result<AlphaMode> alpha_mode_of(const std::string& name, const std::string& where) {
  if (name.empty() || name == "OPAQUE") return AlphaMode::opaque;
  if (name == "MASK") return AlphaMode::mask;
  if (name == "BLEND") return AlphaMode::blend;
  return Error{where + " has the unknown alphaMode " + quote(name)};
}

// Reads factors and modes, but no textures.
Result<Material> plain_material(const tinygltf::Material& source, const std::string& where,
                                std::vector<std::string>& warnings) {
  Material material;
  material.name = source.name;
  const auto& pbr = source.pbrMetallicRoughness;
  const auto unit = [&](double number, const char* member) {
    return in_range_or_warn(number, 0, 1, where + "." + member, warnings);
  };
  for (int i = 0; i < 4; ++i)
    material.base_color[i] = unit(pbr.baseColorFactor[static_cast<size_t>(i)], "baseColorFactor");
  for (int i = 0; i < 3; ++i)
    material.emissive[i] = unit(source.emissiveFactor[static_cast<size_t>(i)], "emissiveFactor");
  material.metallic = unit(pbr.metallicFactor, "metallicFactor");
  material.roughness = unit(pbr.roughnessFactor, "roughnessFactor");
  material.normal_scale = to_float(source.normalTexture.scale);
  material.occlusion_strength = unit(source.occlusionTexture.strength, "occlusionTexture.strength");
  material.alpha_cutoff = to_float(source.alphaCutoff);
  material.double_sided = source.doubleSided;
  material.unlit = source.extensions.contains("KHR_materials_unlit");
  auto alpha_mode = alpha_mode_of(source.alphaMode, where);
  if (!alpha_mode) return alpha_mode.error();
  material.alpha_mode = *alpha_mode;
  return material;
}

Result<Material> material_of(const tinygltf::Material& source, const std::string& where, Textures& textures,
                             std::vector<std::string>& warnings) {
  auto material = plain_material(source, where, warnings);
  if (!material) return material;
  // Generic over TextureInfo, NormalTextureInfo and OcclusionTextureInfo.
  const auto take = [&](TextureRef& to, const auto& info, bool srgb, const char* member) -> Result<void> {
    auto ref = textures.refer(info.index, info.texCoord, info.extensions, srgb, where + "." + member);
    if (!ref) return ref.error();
    to = *ref;
    return {};
  };
  const auto& pbr = source.pbrMetallicRoughness;
  auto done = take(material->base_color_texture, pbr.baseColorTexture, true, "baseColorTexture");
  if (done)
    done = take(material->metallic_roughness_texture, pbr.metallicRoughnessTexture, false,
                "metallicRoughnessTexture");
  if (done) done = take(material->normal_texture, source.normalTexture, false, "normalTexture");
  if (done) done = take(material->occlusion_texture, source.occlusionTexture, false, "occlusionTexture");
  if (done) done = take(material->emissive_texture, source.emissiveTexture, true, "emissiveTexture");
  if (done) done = add_material_extensions(source, where, textures, *material, warnings);
  if (!done) return done.error();
  return material;
}

}  // namespace

Result<std::vector<uint32_t>> add_materials(const GltfDocument& document, Scene& scene) {
  scene.materials.emplace_back().name = "default";
  Textures textures(document, scene);
  for (size_t i = 0; i < document.model.materials.size(); ++i) {
    auto material =
        material_of(document.model.materials[i], element("materials", i), textures, scene.warnings);
    if (!material) return material.error();
    scene.materials.push_back(std::move(*material));
  }
  return textures.take_used_images();
}

}  // namespace fire3dv::scene
