#include "renderer/scene/gltf_materials.h"

#include <algorithm>
#include <map>
#include <utility>

namespace fire3dv::scene {
namespace {

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

// Hands out one Texture for each use of a glTF texture, as colour or as data.
class Textures {
 public:
  Textures(const GltfDocument& document, Scene& scene) : document_(document), scene_(scene) {}

  // kNone with a warning where the texture has no image that could be read.
  Result<uint32_t> find_or_add(int index, bool srgb, const std::string& where) {
    const auto& textures = document_.model.textures;
    if (!in_range(index, textures.size())) return out_of_range(where, "textures", index, textures.size());
    if (const auto known = texture_of_use_.find({index, srgb}); known != texture_of_use_.end())
      return known->second;
    auto texture =
        add(textures[static_cast<size_t>(index)], srgb, element("textures", static_cast<size_t>(index)));
    if (texture) texture_of_use_[{index, srgb}] = *texture;
    return texture;
  }

  std::vector<uint32_t> take_used_images() { return std::move(used_images_); }

 private:
  Result<uint32_t> add(const tinygltf::Texture& source, bool srgb, const std::string& where) {
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
    if (source.source < 0) {
      scene_.warnings.push_back(where + " has no image in a supported format and is left out");
      return kNone;
    }
    if (!in_range(source.source, document_.images.size())) {
      return out_of_range(where, "images", source.source, document_.images.size());
    }
    const auto [slot, added] =
        slot_of_image_.try_emplace(source.source, static_cast<uint32_t>(used_images_.size()));
    if (added) used_images_.push_back(static_cast<uint32_t>(source.source));
    texture.image = slot->second;
    scene_.textures.push_back(texture);
    return static_cast<uint32_t>(scene_.textures.size() - 1);
  }

  const GltfDocument& document_;
  Scene& scene_;
  std::map<std::pair<int, bool>, uint32_t> texture_of_use_;
  std::map<int, uint32_t> slot_of_image_;
  std::vector<uint32_t> used_images_;
};

double number_or(const tinygltf::Value& object, const char* member, double otherwise) {
  return object.Has(member) ? object.Get(member).GetNumberAsDouble() : otherwise;
}

Result<glm::vec2> pair_or(const tinygltf::Value& object, const char* member, glm::vec2 otherwise,
                          const std::string& where) {
  if (!object.Has(member)) return otherwise;
  const tinygltf::Value& pair = object.Get(member);
  if (!pair.IsArray() || pair.ArrayLen() != 2)
    return Error{where + "." + member + " does not hold two numbers"};
  return glm::vec2(to_float(pair.Get(0).GetNumberAsDouble()), to_float(pair.Get(1).GetNumberAsDouble()));
}

// TextureInfo, NormalTextureInfo and OcclusionTextureInfo alike.
template <typename Info>
Result<TextureRef> texture_ref(const Info& info, bool srgb, const std::string& where, Textures& textures,
                               Scene& scene) {
  TextureRef ref;
  if (info.index < 0) return ref;
  auto texture = textures.find_or_add(info.index, srgb, where);
  if (!texture) return texture.error();
  int uv_set = info.texCoord;
  if (const auto found = info.extensions.find("KHR_texture_transform"); found != info.extensions.end()) {
    const tinygltf::Value& transform = found->second;
    const std::string name = where + ".extensions.KHR_texture_transform";
    auto offset = pair_or(transform, "offset", glm::vec2(0), name);
    if (!offset) return offset.error();
    auto scale = pair_or(transform, "scale", glm::vec2(1), name);
    if (!scale) return scale.error();
    ref.uv_offset = *offset;
    ref.uv_scale = *scale;
    ref.uv_rotation_rad = to_float(number_or(transform, "rotation", 0));
    uv_set = static_cast<int>(number_or(transform, "texCoord", uv_set));
  }
  if (uv_set > 1) {
    scene.warnings.push_back(where + " uses TEXCOORD_" + std::to_string(uv_set) +
                             "; only 0 and 1 are read, it is left out");
    return TextureRef{};
  }
  ref.uv_set = static_cast<uint32_t>(uv_set);
  ref.texture = *texture;
  return ref;
}

Result<AlphaMode> alpha_mode_of(const std::string& name, const std::string& where) {
  if (name.empty() || name == "OPAQUE") return AlphaMode::opaque;
  if (name == "MASK") return AlphaMode::mask;
  if (name == "BLEND") return AlphaMode::blend;
  return Error{where + " has the unknown alphaMode " + quote(name)};
}

Result<Material> material_of(const tinygltf::Material& source, const std::string& where, Textures& textures,
                             Scene& scene) {
  Material material;
  material.name = source.name;
  const auto& pbr = source.pbrMetallicRoughness;
  for (int i = 0; i < 4; ++i) material.base_color[i] = to_float(pbr.baseColorFactor[static_cast<size_t>(i)]);
  for (int i = 0; i < 3; ++i) material.emissive[i] = to_float(source.emissiveFactor[static_cast<size_t>(i)]);
  material.metallic = std::clamp(to_float(pbr.metallicFactor), 0.0f, 1.0f);
  material.roughness = std::clamp(to_float(pbr.roughnessFactor), 0.0f, 1.0f);
  material.normal_scale = to_float(source.normalTexture.scale);
  material.occlusion_strength = to_float(source.occlusionTexture.strength);
  material.alpha_cutoff = to_float(source.alphaCutoff);
  material.double_sided = source.doubleSided;
  material.unlit = source.extensions.contains("KHR_materials_unlit");
  if (const auto strength = source.extensions.find("KHR_materials_emissive_strength");
      strength != source.extensions.end()) {
    material.emissive *= to_float(number_or(strength->second, "emissiveStrength", 1));
  }
  auto alpha_mode = alpha_mode_of(source.alphaMode, where);
  if (!alpha_mode) return alpha_mode.error();
  material.alpha_mode = *alpha_mode;

  const auto take = [](TextureRef& to, Result<TextureRef> from) -> Result<void> {
    if (!from) return from.error();
    to = *from;
    return {};
  };
  const auto ref = [&](const auto& info, bool srgb, const char* member) {
    return texture_ref(info, srgb, where + "." + member, textures, scene);
  };
  if (auto ok = take(material.base_color_texture, ref(pbr.baseColorTexture, true, "baseColorTexture")); !ok)
    return ok.error();
  if (auto ok = take(material.metallic_roughness_texture,
                     ref(pbr.metallicRoughnessTexture, false, "metallicRoughnessTexture"));
      !ok)
    return ok.error();
  if (auto ok = take(material.normal_texture, ref(source.normalTexture, false, "normalTexture")); !ok)
    return ok.error();
  if (auto ok = take(material.occlusion_texture, ref(source.occlusionTexture, false, "occlusionTexture"));
      !ok)
    return ok.error();
  if (auto ok = take(material.emissive_texture, ref(source.emissiveTexture, true, "emissiveTexture")); !ok)
    return ok.error();
  return material;
}

}  // namespace

Result<std::vector<uint32_t>> add_materials(const GltfDocument& document, Scene& scene) {
  scene.materials.emplace_back().name = "default";
  Textures textures(document, scene);
  for (size_t i = 0; i < document.model.materials.size(); ++i) {
    auto material = material_of(document.model.materials[i], element("materials", i), textures, scene);
    if (!material) return material.error();
    scene.materials.push_back(std::move(*material));
  }
  return textures.take_used_images();
}

}  // namespace fire3dv::scene
