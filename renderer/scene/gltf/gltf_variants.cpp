#include <algorithm>
#include <string>
#include <vector>

#include "renderer/scene/gltf/gltf_parts.h"

namespace fire3dv::scene {
namespace {

constexpr const char* kExtension = "KHR_materials_variants";
// Limit per file: each primitive with variants has an entry for each of them.
constexpr size_t kMaxVariantMaterials = size_t{1} << 24;

Error not_an_array(const std::string& where) {
  return Error{where + " is not an array"};
}

}  // namespace

Result<void> add_variants(const GltfDocument& document, Scene& scene) {
  const auto extension = document.model.extensions.find(kExtension);
  if (extension == document.model.extensions.end() || !extension->second.Has("variants")) return {};
  const std::string where = std::string("extensions.") + kExtension + ".variants";
  const tinygltf::Value& variants = extension->second.Get("variants");
  if (!variants.IsArray()) return not_an_array(where);
  for (size_t i = 0; i < variants.ArrayLen(); ++i) {
    const tinygltf::Value& variant = variants.Get(static_cast<int>(i));
    if (!variant.IsObject() || !variant.Has("name") || !variant.Get("name").IsString())
      return Error{where + "[" + std::to_string(i) + "]: name is missing"};
    scene.variants.push_back(variant.Get("name").Get<std::string>());
  }
  return {};
}

Result<std::vector<uint32_t>> variant_materials_of(const GltfDocument& document,
                                                   const tinygltf::Primitive& primitive,
                                                   const std::string& where, const Scene& scene) {
  std::vector<uint32_t> materials;
  const auto extension = primitive.extensions.find(kExtension);
  if (extension == primitive.extensions.end() || !extension->second.Has("mappings")) return materials;
  const std::string name = where + ".extensions." + kExtension + ".mappings";
  const tinygltf::Value& mappings = extension->second.Get("mappings");
  if (!mappings.IsArray()) return not_an_array(name);
  if (scene.variant_materials.size() + scene.variants.size() + 1 > kMaxVariantMaterials)
    return Error{name + ": the file has more than " + std::to_string(kMaxVariantMaterials) +
                 " materials of variants; split it"};
  materials.assign(scene.variants.size() + 1, static_cast<uint32_t>(primitive.material + 1));
  for (size_t i = 0; i < mappings.ArrayLen(); ++i) {
    const tinygltf::Value& mapping = mappings.Get(static_cast<int>(i));
    const std::string at = name + "[" + std::to_string(i) + "]";
    if (!mapping.Has("material") || !mapping.Has("variants"))
      return Error{at + (mapping.Has("material") ? ": variants is missing" : ": material is missing")};
    const int material = index_or(mapping, "material", -1);
    if (!in_range(material, document.model.materials.size()))
      return out_of_range(at, "materials", material, document.model.materials.size());
    const tinygltf::Value& variants = mapping.Get("variants");
    for (size_t v = 0; v < variants.ArrayLen(); ++v) {
      const tinygltf::Value& index = variants.Get(static_cast<int>(v));
      const int variant = index.IsNumber() ? index.GetNumberAsInt() : -1;
      if (!in_range(variant, scene.variants.size()))
        return out_of_range(at + ".variants", "variants", variant, scene.variants.size());
      materials[static_cast<size_t>(variant) + 1] = static_cast<uint32_t>(material + 1);
    }
  }
  return materials;
}

}  // namespace fire3dv::scene
