#include "renderer/scene/gltf/gltf_parts.h"

#include <limits>

#include "renderer/scene/gltf/gltf_values.h"
#include "renderer/scene/gltf/materials/gltf_textures.h"

namespace fire3dv::scene {
namespace {

constexpr double kNoUpperLimit = std::numeric_limits<float>::max();

// Reader of one material extension object. It stores the first error, so that callers need no checks in
// between.
class Layer {
 public:
  Layer(const tinygltf::Material& source, const char* extension, const std::string& where, Textures& textures,
        std::vector<std::string>& warnings)
      : where_(where + ".extensions." + extension), textures_(textures), warnings_(warnings) {
    const auto found = source.extensions.find(extension);
    if (found != source.extensions.end()) object_ = &found->second;
  }

  bool there() const { return object_ != nullptr; }
  Result<void> result() const { return fault_.message.empty() ? Result<void>() : Result<void>(fault_); }

  void factor(const char* member, float& value, double low = 0, double high = 1) {
    if (object_->Has(member))
      value = in_range_or_warn(number_or(*object_, member, value), low, high, name(member), warnings_);
  }

  void color(const char* member, glm::vec3& value, double high) {
    if (!object_->Has(member)) return;
    const tinygltf::Value& numbers = object_->Get(member);
    if (!numbers.IsArray() || numbers.ArrayLen() != 3)
      return fail(Error{name(member) + " does not hold three numbers"});
    for (int i = 0; i < 3; ++i)
      value[i] = in_range_or_warn(numbers.Get(i).GetNumberAsDouble(), 0, high, name(member), warnings_);
  }

  void texture(const char* member, bool srgb, TextureRef& value) {
    if (!object_->Has(member)) return;
    const tinygltf::Value& info = object_->Get(member);
    if (!info.Has("index")) return fail(Error{name(member) + ": index is missing"});
    tinygltf::ExtensionMap extensions;
    if (info.Has("extensions") && info.Get("extensions").Has("KHR_texture_transform"))
      extensions["KHR_texture_transform"] = info.Get("extensions").Get("KHR_texture_transform");
    auto ref = textures_.refer(index_or(info, "index", -1), index_or(info, "texCoord", 0), extensions, srgb,
                               name(member));
    if (!ref) return fail(ref.error());
    value = *ref;
  }

  void normal_scale(const char* member, float& value) {
    if (object_->Has(member)) value = to_float(number_or(object_->Get(member), "scale", 1));
  }

  void ior(float& value) {
    const double given = number_or(*object_, "ior", value);
    // ior 0 is a special value: full reflection at all angles.
    value = given == 0 ? 0.0f : in_range_or_warn(given, 1, kNoUpperLimit, name("ior"), warnings_);
  }

 private:
  std::string name(const char* member) const { return where_ + "." + member; }
  void fail(Error fault) {
    if (fault_.message.empty()) fault_ = std::move(fault);
  }

  std::string where_;
  Textures& textures_;
  std::vector<std::string>& warnings_;
  const tinygltf::Value* object_ = nullptr;
  Error fault_;
};

// Reads ior, specular, clearcoat, sheen, transmission and emissive_strength. Out-of-range factors are clamped
// with a warning.
Result<void> add_material_extensions(const tinygltf::Material& source, const std::string& where,
                                     Textures& textures, Material& material,
                                     std::vector<std::string>& warnings) {
  const auto layer = [&](const char* extension) {
    return Layer(source, extension, where, textures, warnings);
  };
  if (Layer emission = layer("KHR_materials_emissive_strength"); emission.there()) {
    float strength = 1;
    emission.factor("emissiveStrength", strength, 0, kNoUpperLimit);
    material.emissive *= strength;
  }
  if (Layer ior = layer("KHR_materials_ior"); ior.there()) ior.ior(material.ior);
  if (Layer specular = layer("KHR_materials_specular"); specular.there()) {
    specular.factor("specularFactor", material.specular);
    specular.color("specularColorFactor", material.specular_color, kNoUpperLimit);
    specular.texture("specularTexture", false, material.specular_texture);
    specular.texture("specularColorTexture", true, material.specular_color_texture);
    if (auto done = specular.result(); !done) return done;
  }
  if (Layer clearcoat = layer("KHR_materials_clearcoat"); clearcoat.there()) {
    clearcoat.factor("clearcoatFactor", material.clearcoat);
    clearcoat.factor("clearcoatRoughnessFactor", material.clearcoat_roughness);
    clearcoat.texture("clearcoatTexture", false, material.clearcoat_texture);
    clearcoat.texture("clearcoatRoughnessTexture", false, material.clearcoat_roughness_texture);
    clearcoat.texture("clearcoatNormalTexture", false, material.clearcoat_normal_texture);
    clearcoat.normal_scale("clearcoatNormalTexture", material.clearcoat_normal_scale);
    if (auto done = clearcoat.result(); !done) return done;
  }
  if (Layer sheen = layer("KHR_materials_sheen"); sheen.there()) {
    sheen.color("sheenColorFactor", material.sheen_color, 1);
    sheen.factor("sheenRoughnessFactor", material.sheen_roughness);
    sheen.texture("sheenColorTexture", true, material.sheen_color_texture);
    sheen.texture("sheenRoughnessTexture", false, material.sheen_roughness_texture);
    if (auto done = sheen.result(); !done) return done;
  }
  if (Layer transmission = layer("KHR_materials_transmission"); transmission.there()) {
    transmission.factor("transmissionFactor", material.transmission);
    transmission.texture("transmissionTexture", false, material.transmission_texture);
    if (auto done = transmission.result(); !done) return done;
  }
  return {};
}

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
