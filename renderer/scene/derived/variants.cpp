#include "renderer/scene/derived/variants.h"

#include <algorithm>

#include "base/nearest_names.h"
#include "base/text.h"

namespace fire3dv::scene {

Result<uint32_t> find_variant(const Scene& scene, std::string_view name) {
  const auto found = std::find(scene.variants.begin(), scene.variants.end(), name);
  if (found != scene.variants.end()) return static_cast<uint32_t>(found - scene.variants.begin());
  return Error{
      "there is no material variant " + quote(name) +
      (scene.variants.empty() ? ": the file has none" : name_hint(name, scene.variants, "variants"))};
}

uint32_t variant_of_same_name(uint32_t variant, const Scene& before, const Scene& after) {
  if (variant >= before.variants.size()) return kNone;
  const auto found = std::find(after.variants.begin(), after.variants.end(), before.variants[variant]);
  return found == after.variants.end() ? kNone : static_cast<uint32_t>(found - after.variants.begin());
}

std::string variant_names(const Scene& scene) {
  std::string names;
  for (const std::string& name : scene.variants) names += (names.empty() ? "" : ", ") + quote(name);
  return names;
}

void select_variant(LoadedScene& loaded, uint32_t variant) {
  Scene& scene = loaded.scene;
  bool has_changed = false;
  for (Primitive& primitive : scene.primitives) {
    if (primitive.first_variant_material == kNone) continue;
    const uint32_t choice = variant == kNone ? 0 : variant + 1;
    const uint32_t material = scene.variant_materials[primitive.first_variant_material + choice];
    has_changed |= material != primitive.material;
    primitive.material = material;
  }
  if (has_changed) loaded.derived.casters = classify_casters(scene);
}

}  // namespace fire3dv::scene
