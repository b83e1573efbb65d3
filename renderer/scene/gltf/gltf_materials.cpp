#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "renderer/scene/gltf/gltf_document.h"
#include "renderer/scene/gltf/gltf_parts.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {
namespace {

// Texture references of materials, with samplers. Creates one Texture per glTF texture and use (colour or
// data).
class Textures {
 public:
  Textures(const GltfDocument& document, Scene& scene) : document_(document), scene_(scene) {}

  // Resolves a textureInfo, including KHR_texture_transform. The result has no texture, and a warning is
  // added, if its image or texture coordinates are unavailable.
  Result<TextureRef> refer(int texture, int uv_set, const tinygltf::ExtensionMap& extensions, bool srgb,
                           const std::string& where);

  // Returns an error if there is no such texture. Its image is not loaded.
  Result<void> check(int texture, const std::string& where) const;

  // Used images as indices into the document's images; Texture::image indexes this list.
  std::vector<uint32_t> take_used_images() { return std::move(used_images_); }

 private:
  Result<uint32_t> find_or_add(int index, bool srgb, const std::string& where);
  Result<uint32_t> add(const tinygltf::Texture& source, bool srgb, const std::string& where);

  const GltfDocument& document_;
  Scene& scene_;
  std::map<std::pair<int, bool>, uint32_t> texture_of_use_;
  std::map<int, uint32_t> slot_of_image_;
  std::vector<uint32_t> used_images_;
};

Result<Wrap> wrap_of(int value, const std::string& where) {
  switch (value) {
    case TINYGLTF_TEXTURE_WRAP_REPEAT:
      return Wrap::repeat;
    case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
      return Wrap::mirrored_repeat;
    case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
      return Wrap::clamp_to_edge;
    default:
      return Error{where + " has the unknown wrap mode " + std::to_string(value)};
  }
}

Result<Sampler> sampler_of(const tinygltf::Sampler& source, const std::string& where) {
  Sampler sampler;
  auto wrap_u = wrap_of(source.wrapS, where);
  if (!wrap_u) return wrap_u.error();
  auto wrap_v = wrap_of(source.wrapT, where);
  if (!wrap_v) return wrap_v.error();
  sampler.wrap_u = *wrap_u;
  sampler.wrap_v = *wrap_v;
  switch (source.magFilter) {
    case -1:
    case TINYGLTF_TEXTURE_FILTER_LINEAR:
      break;
    case TINYGLTF_TEXTURE_FILTER_NEAREST:
      sampler.nearest_mag = true;
      break;
    default:
      return Error{where + " has the unknown magFilter " + std::to_string(source.magFilter)};
  }
  switch (source.minFilter) {
    case -1:
    case TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR:
      break;
    case TINYGLTF_TEXTURE_FILTER_NEAREST:
      sampler.nearest_min = true;
      sampler.use_mips = false;
      break;
    case TINYGLTF_TEXTURE_FILTER_LINEAR:
      sampler.use_mips = false;
      break;
    case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_NEAREST:
      sampler.nearest_min = sampler.nearest_mip = true;
      break;
    case TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_NEAREST:
      sampler.nearest_mip = true;
      break;
    case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_LINEAR:
      sampler.nearest_min = true;
      break;
    default:
      return Error{where + " has the unknown minFilter " + std::to_string(source.minFilter)};
  }
  return sampler;
}

Result<glm::vec2> pair_or(const tinygltf::Value& object, const char* member, glm::vec2 otherwise,
                          const std::string& where) {
  if (!object.Has(member)) return otherwise;
  const tinygltf::Value& pair = object.Get(member);
  if (!pair.IsArray() || pair.ArrayLen() != 2)
    return Error{where + "." + member + " does not hold two numbers"};
  return glm::vec2(to_float(pair.Get(0).GetNumberAsDouble()), to_float(pair.Get(1).GetNumberAsDouble()));
}

// Returns kNone with a warning if the texture has no readable image.
Result<uint32_t> Textures::find_or_add(int index, bool srgb, const std::string& where) {
  const auto& textures = document_.model.textures;
  if (!in_range(index, textures.size())) return out_of_range(where, "textures", index, textures.size());
  if (const auto known = texture_of_use_.find({index, srgb}); known != texture_of_use_.end())
    return known->second;
  auto texture =
      add(textures[static_cast<size_t>(index)], srgb, element("textures", static_cast<size_t>(index)));
  if (texture) texture_of_use_[{index, srgb}] = *texture;
  return texture;
}

Result<uint32_t> Textures::add(const tinygltf::Texture& source, bool srgb, const std::string& where) {
  Texture texture;
  texture.srgb = srgb;
  if (source.sampler >= 0) {
    const auto& samplers = document_.model.samplers;
    if (!in_range(source.sampler, samplers.size()))
      return out_of_range(where, "samplers", source.sampler, samplers.size());
    const auto index = static_cast<size_t>(source.sampler);
    auto sampler = sampler_of(samplers[index], element("samplers", index));
    if (!sampler) return sampler.error();
    texture.sampler = *sampler;
  }
  const int image = image_of(source);
  if (image < 0) {
    scene_.warnings.push_back(where + " has no image in a supported format and is left out");
    return kNone;
  }
  if (!in_range(image, document_.images.size())) {
    return out_of_range(where, "images", image, document_.images.size());
  }
  const auto [slot, added] = slot_of_image_.try_emplace(image, static_cast<uint32_t>(used_images_.size()));
  if (added) used_images_.push_back(static_cast<uint32_t>(image));
  texture.image = slot->second;
  scene_.textures.push_back(texture);
  return static_cast<uint32_t>(scene_.textures.size() - 1);
}

Result<TextureRef> Textures::refer(int texture, int uv_set, const tinygltf::ExtensionMap& extensions,
                                   bool srgb, const std::string& where) {
  TextureRef ref;
  if (texture < 0) return ref;
  auto added = find_or_add(texture, srgb, where);
  if (!added) return added.error();
  if (const auto found = extensions.find("KHR_texture_transform"); found != extensions.end()) {
    const tinygltf::Value& transform = found->second;
    const std::string name = where + ".extensions.KHR_texture_transform";
    auto offset = pair_or(transform, "offset", glm::vec2(0), name);
    if (!offset) return offset.error();
    auto scale = pair_or(transform, "scale", glm::vec2(1), name);
    if (!scale) return scale.error();
    ref.uv_offset = *offset;
    ref.uv_scale = *scale;
    ref.uv_rotation_rad = to_float(number_or(transform, "rotation", 0));
    uv_set = index_or(transform, "texCoord", uv_set);
  }
  if (uv_set > 1) {
    scene_.warnings.push_back(where + " uses TEXCOORD_" + std::to_string(uv_set) +
                              "; only 0 and 1 are read, it is left out");
    return TextureRef{};
  }
  ref.uv_set = static_cast<uint32_t>(uv_set);
  ref.texture = *added;
  return ref;
}

Result<void> Textures::check(int texture, const std::string& where) const {
  const auto& textures = document_.model.textures;
  if (!in_range(texture, textures.size())) return out_of_range(where, "textures", texture, textures.size());
  return {};
}

constexpr const char* kSpecularGlossiness = "KHR_materials_pbrSpecularGlossiness";
constexpr double kNoUpperLimit = std::numeric_limits<float>::max();
constexpr double kLeastAttenuationDistance = 1e-6;  // metres
// Far beyond interference of visible light; finite phases in 32-bit floats.
constexpr double kMaxFilmThicknessNm = 1e6, kMaxFilmIor = 1e3;

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
    if (object_->Has(member) && !object_->Get(member).IsNumber())
      return fail(Error{name(member) + " is not a number"});
    if (object_->Has(member))
      value = in_range_or_warn(number_or(*object_, member, value), low, high, name(member), warnings_);
  }

  template <int kChannels>
  void color(const char* member, glm::vec<kChannels, float>& value, double high) {
    if (!object_->Has(member)) return;
    const tinygltf::Value& numbers = object_->Get(member);
    if (!numbers.IsArray() || numbers.ArrayLen() != kChannels)
      return fail(Error{name(member) + " does not hold " + (kChannels == 3 ? "three" : "four") + " numbers"});
    for (int i = 0; i < kChannels; ++i)
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

  // Checks a texture without use, whose image is not loaded.
  void unused_texture(const char* member) {
    if (!object_->Has(member)) return;
    const tinygltf::Value& info = object_->Get(member);
    if (!info.Has("index")) return fail(Error{name(member) + ": index is missing"});
    if (auto done = textures_.check(index_or(info, "index", -1), name(member)); !done) fail(done.error());
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

// Reads ior, specular, clearcoat, sheen, anisotropy, iridescence, transmission, volume, dispersion,
// diffuse_transmission and emissive_strength. Out-of-range factors are clamped with a warning.
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
  if (Layer anisotropy = layer("KHR_materials_anisotropy"); anisotropy.there()) {
    anisotropy.factor("anisotropyStrength", material.anisotropy);
    anisotropy.factor("anisotropyRotation", material.anisotropy_rotation_rad, -kNoUpperLimit, kNoUpperLimit);
    anisotropy.texture("anisotropyTexture", false, material.anisotropy_texture);
    if (auto done = anisotropy.result(); !done) return done;
  }
  if (Layer film = layer("KHR_materials_iridescence"); film.there()) {
    film.factor("iridescenceFactor", material.iridescence);
    film.factor("iridescenceIor", material.iridescence_ior, 1, kMaxFilmIor);
    film.factor("iridescenceThicknessMinimum", material.iridescence_thickness_min_nm, 0, kMaxFilmThicknessNm);
    film.factor("iridescenceThicknessMaximum", material.iridescence_thickness_max_nm, 0, kMaxFilmThicknessNm);
    film.texture("iridescenceTexture", false, material.iridescence_texture);
    film.texture("iridescenceThicknessTexture", false, material.iridescence_thickness_texture);
    if (auto done = film.result(); !done) return done;
  }
  if (Layer transmission = layer("KHR_materials_transmission"); transmission.there()) {
    transmission.factor("transmissionFactor", material.transmission);
    transmission.texture("transmissionTexture", false, material.transmission_texture);
    if (auto done = transmission.result(); !done) return done;
  }
  if (Layer volume = layer("KHR_materials_volume"); volume.there()) {
    volume.factor("thicknessFactor", material.thickness, 0, kNoUpperLimit);
    volume.unused_texture("thicknessTexture");  // rays measure the thickness; thin walls have none
    volume.factor("attenuationDistance", material.attenuation_distance_m, kLeastAttenuationDistance,
                  kNoUpperLimit);
    volume.color("attenuationColor", material.attenuation_color, 1);
    if (auto done = volume.result(); !done) return done;
  }
  if (Layer dispersion = layer("KHR_materials_dispersion"); dispersion.there()) {
    dispersion.factor("dispersion", material.dispersion, 0, kNoUpperLimit);
    if (auto done = dispersion.result(); !done) return done;
  }
  if (Layer diffuse = layer("KHR_materials_diffuse_transmission"); diffuse.there()) {
    diffuse.factor("diffuseTransmissionFactor", material.diffuse_transmission);
    diffuse.color("diffuseTransmissionColorFactor", material.diffuse_transmission_color, 1);
    diffuse.texture("diffuseTransmissionTexture", false, material.diffuse_transmission_texture);
    diffuse.texture("diffuseTransmissionColorTexture", true, material.diffuse_transmission_color_texture);
    if (auto done = diffuse.result(); !done) return done;
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

// Returns nullopt if the material has no such extension.
Result<std::optional<SpecularGlossinessMaterial>> specular_glossiness_of(const tinygltf::Material& source,
                                                                         const std::string& where,
                                                                         Textures& textures,
                                                                         std::vector<std::string>& warnings) {
  Layer layer(source, kSpecularGlossiness, where, textures, warnings);
  if (!layer.there()) return std::optional<SpecularGlossinessMaterial>();
  SpecularGlossinessMaterial found;
  layer.color("diffuseFactor", found.factors.diffuse, 1);
  layer.color("specularFactor", found.factors.specular, 1);
  layer.factor("glossinessFactor", found.factors.glossiness);
  layer.texture("diffuseTexture", true, found.diffuse);
  layer.texture("specularGlossinessTexture", true, found.specular_glossiness);
  if (auto done = layer.result(); !done) return done.error();
  return std::optional(found);
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
  auto pbr = source.pbrMetallicRoughness;
  // They are its fallback.
  if (source.extensions.contains(kSpecularGlossiness))
    pbr.baseColorTexture.index = pbr.metallicRoughnessTexture.index = -1;
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

namespace {

// Extensions that the materials use and that are not drawn exactly: one warning for the file.
void report_approximations(const MaterialSources& sources, Scene& scene) {
  const auto is_rough_glass = [](const Material& material) {
    return material.transmission > 0 && !material.unlit && material.roughness > 0;
  };
  std::string list;
  const auto add = [&](const std::string& extension, const char* how) {
    list += (list.empty() ? " " : ", ") + quote(extension) + " (" + how + ")";
  };
  if (std::any_of(scene.materials.begin(), scene.materials.end(), is_rough_glass))
    add("KHR_materials_transmission",
        "what lies behind rough surfaces is not blurred without --ray-effects refraction");
  const auto refracts = [](const Material& material) {
    return material.transmission > 0 && is_volume(material);
  };
  if (std::any_of(scene.materials.begin(), scene.materials.end(), refracts))
    add("KHR_materials_volume", "thin walls without --ray-effects refraction or --render path");
  const auto disperses = [](const Material& material) {
    return is_volume(material) && material.dispersion > 0;
  };
  if (std::any_of(scene.materials.begin(), scene.materials.end(), disperses))
    add("KHR_materials_dispersion",
        "light is not split into colours without --ray-effects refraction or --render path");
  if (!sources.specular_glossiness.empty()) add(kSpecularGlossiness, "converted to metallic-roughness");
  if (!list.empty()) scene.warnings.push_back("extensions that are approximated:" + list);
}

// glTF has no background; it is read from the extras of the scene.
Result<void> add_sky(const tinygltf::Model& model, Textures& textures, Scene& scene) {
  const int shown = std::max(model.defaultScene, 0);
  if (!in_range(shown, model.scenes.size())) return {};
  const std::string where = element("scenes", static_cast<size_t>(shown)) + ".extras.skyTexture";
  const tinygltf::Value& extras = model.scenes[static_cast<size_t>(shown)].extras;
  if (!extras.Has("skyTexture")) return {};
  const tinygltf::Value& sky = extras.Get("skyTexture");
  const double index = sky.IsNumber() ? sky.GetNumberAsDouble() : -1;
  if (!(index >= 0 && index <= std::numeric_limits<int>::max())) {
    scene.warnings.push_back(where + " is no index of a texture: the scene has no sky");
    return {};
  }
  auto used = textures.refer(static_cast<int>(index), 0, {}, true, where);
  if (!used) return used.error();
  scene.sky_texture = used->texture;
  return {};
}

}  // namespace

Result<MaterialSources> add_materials(const GltfDocument& document, Scene& scene) {
  scene.materials.emplace_back().name = "default";
  MaterialSources sources;
  Textures textures(document, scene);
  for (size_t i = 0; i < document.model.materials.size(); ++i) {
    const tinygltf::Material& source = document.model.materials[i];
    const std::string where = element("materials", i);
    auto material = material_of(source, where, textures, scene.warnings);
    if (!material) return material.error();
    auto specular_glossiness = specular_glossiness_of(source, where, textures, scene.warnings);
    if (!specular_glossiness) return specular_glossiness.error();
    if (*specular_glossiness) {
      (*specular_glossiness)->material = static_cast<uint32_t>(scene.materials.size());
      sources.specular_glossiness.push_back(**specular_glossiness);
    }
    scene.materials.push_back(std::move(*material));
  }
  if (auto done = add_sky(document.model, textures, scene); !done) return done.error();
  sources.used_images = textures.take_used_images();
  report_approximations(sources, scene);
  return sources;
}

}  // namespace fire3dv::scene
