// Material variants of a scene (KHR_materials_variants): named choices of the materials of its primitives.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/error.h"
#include "renderer/scene/derived/loaded_scene.h"

namespace fire3dv::scene {

// The first variant of this name, or an error that lists the names.
Result<uint32_t> find_variant(const Scene& scene, std::string_view name);

// Number of the variant in another scene, by name; kNone: it has none of the name.
uint32_t variant_of_same_name(uint32_t variant, const Scene& before, const Scene& after);

// Names in quotes, in the file's order, separated by commas.
std::string variant_names(const Scene& scene);

// Sets the materials of the primitives. kNone: the file's default materials. Classifies the shadow casters
// again if a material changes.
void select_variant(LoadedScene& loaded, uint32_t variant);

}  // namespace fire3dv::scene
