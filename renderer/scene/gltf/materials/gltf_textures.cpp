#include "renderer/scene/gltf/materials/gltf_textures.h"

#include "renderer/scene/gltf/gltf_values.h"

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

Result<glm::vec2> pair_or(const tinygltf::Value& object, const char* member, glm::vec2 otherwise,
                          const std::string& where) {
  if (!object.Has(member)) return otherwise;
  const tinygltf::Value& pair = object.Get(member);
  if (!pair.IsArray() || pair.ArrayLen() != 2)
    return Error{where + "." + member + " does not hold two numbers"};
  return glm::vec2(to_float(pair.Get(0).GetNumberAsDouble()), to_float(pair.Get(1).GetNumberAsDouble()));
}

}  // namespace

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

}  // namespace fire3dv::scene
