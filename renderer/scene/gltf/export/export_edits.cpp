#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"
#include "renderer/scene/gltf/export/export_parts.h"
#include "renderer/scene/model/shortest.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;

constexpr size_t kMaxInstancesOfExport = size_t{1} << 20;  // as in the loader
constexpr const char* kLightsExtension = "KHR_lights_punctual";
constexpr const char* kVisibility = "KHR_node_visibility";
constexpr const char* kSpecularGlossinessName = "KHR_materials_pbrSpecularGlossiness";

json numbers(std::span<const float> values) {
  json list = json::array();
  for (const float value : values) list.push_back(shortest(value));
  return list;
}

template <int length>
json numbers(const glm::vec<length, float>& vector) {
  return numbers(std::span<const float>(&vector.x, static_cast<size_t>(length)));
}

}  // namespace

// In the order of the loader (gltf_nodes.cpp): parents first, children in file order, instances after their
// node.
void GlbExport::map_nodes() {
  const json& nodes = root_["nodes"];
  std::vector<uint32_t> parents(nodes.size(), kNone);
  for (uint32_t i = 0; i < nodes.size(); ++i) {
    for (const json& child : nodes.at(i).value("children", json::array()))
      parents.at(child.get<size_t>()) = i;
  }
  struct Pending {
    uint32_t node;
    bool hidden;
  };
  std::vector<Pending> pending;
  roots_ = roots_of(parents);
  for (auto root = roots_.rbegin(); root != roots_.rend(); ++root) pending.push_back({*root, false});
  size_t instance_count = 0;
  std::vector<bool> is_visited(nodes.size(), false);
  while (!pending.empty()) {
    const auto [source, is_hidden_above] = pending.back();
    pending.pop_back();
    if (is_visited.at(source)) throw std::runtime_error("a node has two parents, or is its own ancestor");
    is_visited[source] = true;
    source_of_node_.push_back(source);
    const json& node = nodes[source];
    const json* const visibility = extension(node, kVisibility);
    const bool hidden = is_hidden_above || (visibility && !visibility->value("visible", true));
    if (const json* const instances = extension(node, "EXT_mesh_gpu_instancing");
        instances && !hidden && node.contains("mesh")) {
      const auto accessor = instances->at("attributes").begin()->get<size_t>();
      const auto count = root_["accessors"].at(accessor).at("count").get<size_t>();
      if (count > kMaxInstancesOfExport - instance_count)
        throw std::runtime_error("the file holds more than " + std::to_string(kMaxInstancesOfExport) +
                                 " instances");
      instance_count += count;
      for (size_t i = 0; i < count; ++i) {
        mark_instance(source_of_node_.size());
        source_of_node_.push_back(kNone);
      }
    }
    const json children = node.value("children", json::array());
    for (auto child = children.rbegin(); child != children.rend(); ++child)
      pending.push_back({child->get<uint32_t>(), hidden});
  }
}

void GlbExport::mark_instance(size_t node) {
  if (is_instance_.size() <= node) is_instance_.resize(node + 1);
  is_instance_[node] = true;
}

// Of the default scene. A node that the scene names beside one of its ancestors is no root.
std::vector<uint32_t> GlbExport::roots_of(const std::vector<uint32_t>& parents) const {
  std::vector<uint32_t> roots;
  const auto scenes = root_.find("scenes");
  if (scenes == root_.end() || scenes->empty()) {
    for (uint32_t i = 0; i < parents.size(); ++i)
      if (parents[i] == kNone) roots.push_back(i);
    return roots;
  }
  std::vector<bool> is_root(parents.size(), false);
  for (const json& root : scenes->at(root_.value("scene", size_t{0})).value("nodes", json::array())) {
    const auto node = root.get<uint32_t>();
    if (node >= parents.size() || is_root[node]) continue;
    is_root[node] = true;
    roots.push_back(node);
  }
  std::erase_if(roots, [&](uint32_t root) {
    uint32_t above = parents[root];
    for (size_t steps = 0; above != kNone && steps < parents.size(); ++steps) {
      if (is_root[above]) return true;
      above = parents[above];
    }
    return false;
  });
  return roots;
}

std::set<uint32_t> GlbExport::animated_nodes() const {
  std::set<uint32_t> nodes;
  for (const json& animation : root_.value("animations", json::array())) {
    for (const json& channel : animation.value("channels", json::array())) {
      const json target = channel.value("target", json::object());
      if (target.contains("node")) nodes.insert(target["node"].get<uint32_t>());
    }
  }
  return nodes;
}

// Parts where the loader makes the same matrix of them, else the matrix; animations need parts.
void GlbExport::place(json& node, const ExportedTransform& transform, bool is_animated) {
  const glm::dquat given(transform.rotation);
  const glm::quat loaded(given / glm::length(given));
  const bool is_exact =
      transform.has_parts &&
      parent_from_parts(transform.translation, loaded, transform.scale) == transform.parent_from_node;
  for (const char* const member : {"matrix", "translation", "rotation", "scale"}) node.erase(member);
  if (is_exact || (is_animated && transform.has_parts)) {
    const glm::quat& q = transform.rotation;
    node["translation"] = numbers(transform.translation);
    node["rotation"] = numbers(glm::vec4(q.x, q.y, q.z, q.w));
    node["scale"] = numbers(transform.scale);
    return;
  }
  if (is_animated)
    warnings_.push_back("node " + quote(node.value("name", std::string())) +
                        " has shear, so that its animation has no effect in the file");
  node["matrix"] = numbers(std::span<const float>(&transform.parent_from_node[0][0], 16));
}

void GlbExport::use_extension(const char* name, const char* list) {
  json& used = root_[list];
  if (!used.is_array()) used = json::array();
  if (std::find(used.begin(), used.end(), name) == used.end()) used.push_back(name);
}

// glTF's invisible nodes have no lights, ours keep them: nodes are hidden below which no light is, and meshes
// beside lights by a node of their own.
void GlbExport::hide(const std::set<uint32_t>& sources) {
  lit_below_.assign(root_["nodes"].size(), std::nullopt);
  for (const uint32_t source : sources) hide_around_lights(source);
}

bool GlbExport::has_light(uint32_t node) const {
  return extension(root_.at("nodes").at(node), kLightsExtension) != nullptr;
}

bool GlbExport::is_lit_below(uint32_t node) {
  if (lit_below_[node]) return *lit_below_[node];
  bool is_lit = has_light(node);
  std::vector<uint32_t> pending{node};
  while (!pending.empty() && !is_lit) {
    const json& at = root_["nodes"].at(pending.back());
    pending.pop_back();
    for (const json& child : at.value("children", json::array())) {
      is_lit |= has_light(child.get<uint32_t>());
      pending.push_back(child.get<uint32_t>());
    }
  }
  lit_below_[node] = is_lit;
  return is_lit;
}

void GlbExport::hide_node(uint32_t node) {
  root_["nodes"][node]["extensions"][kVisibility] = {{"visible", false}};
  use_extension(kVisibility);
}

void GlbExport::hide_around_lights(uint32_t first) {
  std::vector<uint32_t> pending{first};
  while (!pending.empty()) {
    const uint32_t node = pending.back();
    pending.pop_back();
    if (!is_lit_below(node)) {
      hide_node(node);
      continue;
    }
    json& lit = root_["nodes"][node];
    for (const json& child : lit.value("children", json::array())) pending.push_back(child.get<uint32_t>());
    if (!lit.contains("mesh")) continue;
    json mesh = json::object();
    for (const char* const member : {"mesh", "skin", "weights"}) {
      if (!lit.contains(member)) continue;
      mesh[member] = lit[member];
      lit.erase(member);
    }
    if (extension(lit, "EXT_mesh_gpu_instancing")) {
      mesh["extensions"]["EXT_mesh_gpu_instancing"] = lit["extensions"]["EXT_mesh_gpu_instancing"];
      lit["extensions"].erase("EXT_mesh_gpu_instancing");
    }
    const auto added = static_cast<uint32_t>(root_["nodes"].size());
    lit["children"].push_back(added);
    root_["nodes"].push_back(std::move(mesh));  // `lit` is invalid from here on
    lit_below_.emplace_back(false);
    hide_node(added);
  }
}

void GlbExport::set_light(uint32_t node, const Light& light) {
  constexpr const char* kTypes[] = {"directional", "point", "spot"};
  json text = {{"type", kTypes[static_cast<size_t>(light.type)]},
               {"color", numbers(light.color)},
               {"intensity", shortest(light.intensity)}};
  if (!light.name.empty()) text["name"] = light.name;
  if (light.range_m > 0 && light.type != LightType::directional) text["range"] = shortest(light.range_m);
  if (light.type == LightType::spot)
    text["spot"] = {{"innerConeAngle", shortest(light.inner_cone_rad)},
                    {"outerConeAngle", shortest(light.outer_cone_rad)}};
  if (light.type == LightType::directional && light.angular_radius_rad > 0)
    text["extras"]["angular_radius"] = shortest(light.angular_radius_rad);
  if (light.type != LightType::directional && light.radius_m > 0)
    text["extras"]["radius"] = shortest(light.radius_m);
  if (light.type == LightType::point && light.spread > 0) text["extras"]["spread"] = shortest(light.spread);
  json& at = root_["nodes"][node];
  if (!light.casts_shadow)
    warnings_.push_back("the light of node " + quote(at.value("name", std::string())) +
                        " casts shadows in the file: glTF cannot say that it does not");
  json& lights = root_["extensions"][kLightsExtension]["lights"];
  if (!lights.is_array()) lights = json::array();
  at["extensions"][kLightsExtension]["light"] = lights.size();
  lights.push_back(std::move(text));
  use_extension(kLightsExtension);
}

void GlbExport::set_factors(json& material, const MaterialFactors& factors) {
  json& pbr = material["pbrMetallicRoughness"];
  pbr["baseColorFactor"] = numbers(factors.base_color);
  pbr["metallicFactor"] = shortest(factors.metallic);
  pbr["roughnessFactor"] = shortest(factors.roughness);
  // A power of two divides without rounding.
  const float brightest = std::max({factors.emissive.r, factors.emissive.g, factors.emissive.b});
  const float strength = brightest > 1 ? std::exp2(std::ceil(std::log2(brightest))) : 1;
  material["emissiveFactor"] = numbers(factors.emissive / strength);
  if (material.contains("extensions")) material["extensions"].erase("KHR_materials_emissive_strength");
  if (strength > 1) {
    material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = shortest(strength);
    use_extension("KHR_materials_emissive_strength");
  }
  if (material.contains("normalTexture")) material["normalTexture"]["scale"] = shortest(factors.normal_scale);
  if (material.contains("occlusionTexture"))
    material["occlusionTexture"]["strength"] = shortest(factors.occlusion_strength);
  if (material.value("alphaMode", std::string()) == "MASK")
    material["alphaCutoff"] = shortest(factors.alpha_cutoff);
}

// The mappings stay, so that the other variants can be chosen. Of two mappings the later one counts, as in
// the loader.
void GlbExport::set_variant(size_t variant) {
  if (!root_.contains("meshes")) return;
  for (Json& mesh : root_["meshes"]) {
    for (Json& primitive : mesh["primitives"]) {
      const Json* const own = extension(primitive, "KHR_materials_variants");
      if (!own) continue;
      std::optional<Json> material;
      for (const Json& mapping : own->value("mappings", Json::array())) {
        const Json variants = mapping.value("variants", Json::array());
        if (std::find(variants.begin(), variants.end(), variant) != variants.end())
          material = mapping.at("material");
      }
      if (material) primitive["material"] = std::move(*material);
    }
  }
}

// The first one of each file is glTF's default material, of primitives without one; the file's materials
// follow.
void GlbExport::set_material(uint32_t number, const MaterialFactors& factors) {
  const auto range = std::ranges::find_if(material_ranges_, [&](const MaterialRange& each) {
    return number >= each.first && number - each.first < each.count;
  });
  if (range == material_ranges_.end()) {
    warnings_.push_back("material " + std::to_string(number) + " is not of the file, and is left out");
    return;
  }
  if (number > range->first) {
    json& material = root_["materials"].at(range->first_in_file + number - range->first - 1);
    if (extension(material, kSpecularGlossinessName)) {
      warnings_.push_back("material " + quote(material.value("name", std::string())) +
                          " keeps the factors of the file: they are specular and glossiness");
      return;
    }
    return set_factors(material, factors);
  }
  set_default_material(range->first_mesh, range->mesh_count, factors);
}

void GlbExport::set_default_material(size_t first_mesh, size_t mesh_count, const MaterialFactors& factors) {
  json& materials = root_["materials"];
  if (!materials.is_array()) materials = json::array();
  const size_t added = materials.size();
  materials.push_back(json::object());
  set_factors(materials.back(), factors);
  for (size_t mesh = first_mesh; mesh < first_mesh + mesh_count; ++mesh) {
    for (json& primitive : root_["meshes"].at(mesh)["primitives"])
      if (!primitive.contains("material")) primitive["material"] = added;
  }
}

Result<void> GlbExport::apply(const ExportedEdits& edits) {
  map_nodes();
  const auto size = [&](const char* array) { return root_.value(array, json::array()).size(); };
  material_ranges_ = {{0, static_cast<uint32_t>(size("materials") + 1), 0, 0, size("meshes")}};
  size_t missing = 0;
  const auto source = [&](uint32_t node) -> std::optional<uint32_t> {
    if (node < source_of_node_.size() && source_of_node_[node] != kNone) return source_of_node_[node];
    ++missing;
    return std::nullopt;
  };
  for (const auto& [node, name] : edits.names) {
    const bool is_of_file = node < source_of_node_.size() && source_of_node_[node] != kNone;
    if (is_of_file && root_["nodes"].at(source_of_node_[node]).value("name", std::string()) != name)
      return Error{"node " + quote(name) + " is not where it was: the file has changed since it was loaded"};
  }
  missing += add_nodes(edits.added);
  const std::set<uint32_t> animated = animated_nodes();
  for (const auto& [node, transform] : edits.transforms) {
    if (const auto at = source(node)) place(root_["nodes"][*at], transform, animated.contains(*at));
  }
  for (const auto& [node, light] : edits.lights) {
    if (const auto at = source(node)) set_light(*at, light);
  }
  std::set<uint32_t> hidden;
  for (const uint32_t node : edits.hidden) {
    if (const auto at = source(node)) hidden.insert(*at);
  }
  hide(hidden);
  for (const uint32_t node : edits.removed) {
    if (const auto at = source(node)) hide_node(*at);
  }
  if (edits.variant != kNone) set_variant(edits.variant);
  for (const auto& [number, factors] : edits.materials) set_material(number, factors);
  if (root_.contains("materials") && root_["materials"].empty()) root_.erase("materials");
  if (missing != 0)
    warnings_.push_back(std::to_string(missing) +
                        " edits are left out: their nodes are instances, or not of the scene's file");
  return {};
}

}  // namespace fire3dv::scene
