// Additions of a randomisation to a scene, before its first image: textures that materials choose from, and
// the nodes of distractors. Both are there in all images; draws choose the texture and which nodes are shown.
#pragma once

#include <memory>
#include <set>
#include <string>

#include "base/error.h"
#include "renderer/dataset/randomize/plan.h"
#include "renderer/scene/derived/loaded_scene.h"

namespace fire3dv::dataset {

// Name of a material, "#3" of the fourth one without.
std::string material_name(const scene::Scene& scene, size_t material);

// Returns null if the plan adds nothing. Errors name file, line and field.
Result<std::unique_ptr<const scene::LoadedScene>> add_to_scene(const Plan& plan,
                                                               const scene::LoadedScene& loaded);

// Number of an added texture, by the text of the plan; kNone: the scene has none. is_color: of a base colour.
uint32_t find_texture(const scene::Scene& scene, const std::string& file, bool is_color);

// Nodes of distractors, by file and copy from 1 on. kNone: the scene has none.
uint32_t find_distractor(const scene::Scene& scene, const std::string& file, uint32_t copy);
uint32_t copies_of(const Entry& distractors);
// All nodes of distractors and below them.
std::set<uint32_t> distractor_nodes(const Plan& plan, const scene::Scene& scene);

}  // namespace fire3dv::dataset
