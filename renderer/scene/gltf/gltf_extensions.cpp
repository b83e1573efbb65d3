#include "renderer/scene/gltf/gltf_extensions.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "renderer/scene/gltf/gltf_document.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;

struct Omission {
  std::string_view name;    // of the extension; a part of it where `is_part`
  std::string_view effect;  // on the image
  bool is_part = false;
};

// Exact names first, then families.
constexpr Omission kOmissions[]{
    {"KHR_materials_volume_scatter", "no light scatters inside objects"},
    {"KHR_techniques_webgl", "materials look plain"},
    {"EXT_lights_image_based", "the file's environment is not used"},
    {"EXT_lights_ies", "lights shine evenly"},
    {"KHR_animation_pointer", "only nodes and morph weights are animated"},
    {"KHR_node_selectability", "no effect on images"},
    {"KHR_node_hoverability", "no effect on images"},
    {"KHR_interactivity", "the scene does not react"},
    {"KHR_xmp", "metadata"},
    {"KHR_xmp_json_ld", "metadata"},
    {"MSFT_lod", "the finest level is drawn"},
    {"MSFT_packing_normalRoughnessMetallic", "the unpacked textures are used"},
    {"MSFT_packing_occlusionRoughnessMetallic", "the unpacked textures are used"},
    {"CESIUM_primitive_outline", "outlines are not drawn"},
    {"EXT_mesh_primitive_edge_visibility", "edges are not drawn"},
    {"EXT_mesh_manifold", "metadata"},
    {"EXT_mesh_features", "metadata"},
    {"EXT_instance_features", "metadata"},
    {"EXT_structural_metadata", "metadata"},
    {"AGI_articulations", "metadata"},
    {"AGI_stk_metadata", "metadata"},
    {"FB_geometry_metadata", "metadata"},
    {"GRIFFEL_bim_data", "metadata"},
    {"GODOT_single_root", "metadata"},
    {"VRM", "metadata"},
    {"_materials_", "materials look plainer", true},
    {"_texture_", "images of other formats are left out, or replaced by the file's fallback", true},
    {"_lights_", "some lights are missing", true},
    {"_audio", "no sound", true},
    {"_physics", "no physics", true},
    {"_rigid_bod", "no physics", true},
    {"_implicit_shapes", "no physics", true},
    {"VRMC_", "metadata", true},
};

// Names in the order of their first mention.
Result<std::vector<std::string>> unsupported(const json& document, const char* member) {
  std::vector<std::string> names;
  const auto list = document.find(member);
  if (list == document.end()) return names;
  if (!list->is_array()) return Error{std::string(member) + " is not an array"};
  for (const json& name : *list) {
    if (!name.is_string()) return Error{std::string(member) + " holds something that is not a string"};
    const auto& text = name.get_ref<const std::string&>();
    if (!extension_supported(text) && std::find(names.begin(), names.end(), text) == names.end())
      names.push_back(text);
  }
  return names;
}

}  // namespace

std::string_view effect_of_omission(std::string_view extension) {
  for (const Omission& omission : kOmissions) {
    if (omission.is_part ? extension.find(omission.name) != std::string_view::npos
                         : extension == omission.name) {
      return omission.effect;
    }
  }
  return {};
}

Result<void> check_extensions(const json& document, std::vector<std::string>& warnings) {
  auto required = unsupported(document, "extensionsRequired");
  if (!required) return required.error();
  auto names = unsupported(document, "extensionsUsed");
  if (!names) return names.error();
  for (const std::string& name : *required) {
    if (effect_of_omission(name).empty()) {
      return Error{"the file requires the extension " + quote(name) +
                   ", which is not supported and may change geometry or data: export the file without it"};
    }
    if (std::find(names->begin(), names->end(), name) == names->end()) names->push_back(name);
  }
  if (names->empty()) return {};
  std::string line = "extensions that are not supported are left out:";
  for (const std::string& name : *names) {
    const std::string_view effect = effect_of_omission(name);
    line += (&name == &names->front() ? " " : ", ") + quote(name);
    if (!effect.empty()) line += " (" + std::string(effect) + ")";
  }
  warnings.push_back(std::move(line));
  return {};
}

}  // namespace fire3dv::scene
