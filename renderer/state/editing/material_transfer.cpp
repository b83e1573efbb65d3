#include "renderer/state/editing/material_transfer.h"

#include <algorithm>

namespace fire3dv::state {

MaterialTransfer::MaterialTransfer(const EditTargets& before, const EditTargets& after)
    : before_(before), after_(after) {}

std::span<const MaterialTransfer::User> MaterialTransfer::users_of(Side& side, uint32_t material) {
  if (!side.users) {
    const scene::Scene& scene = side.targets.scene;
    side.users.emplace();
    for (uint32_t node = 0; node < scene.nodes.size(); ++node) {
      if (scene.nodes[node].mesh == kNone) continue;
      const scene::Mesh& mesh = scene.meshes[scene.nodes[node].mesh];
      for (uint32_t slot = 0; slot < mesh.primitive_count; ++slot)
        side.users->push_back({scene.primitives[mesh.first_primitive + slot].material, node, slot});
    }
    std::ranges::stable_sort(*side.users, {}, &User::material);
  }
  const auto users = std::ranges::equal_range(*side.users, material, {}, &User::material);
  return {users.begin(), users.end()};
}

// kNone: there is none. Instances have no path, and stay where those of their node do.
uint32_t MaterialTransfer::same_node(uint32_t node, Side& from, Side& to) {
  const std::vector<scene::Node>&nodes = from.targets.scene.nodes, &others = to.targets.scene.nodes;
  if (!nodes[node].path.empty())
    return to.index.find(from.index.key_of(EditedObject::node, node, EditedProperty::visible));
  if (node >= others.size() || !others[node].path.empty()) return kNone;
  const uint32_t parent = nodes[node].parent, other = others[node].parent;
  const bool is_same = parent != kNone && other != kNone && nodes[parent].path == others[other].path;
  return is_same ? node : kNone;
}

// Of the same name; kNone: there is none. The first users may have been removed, as one of two copies.
uint32_t MaterialTransfer::material_at_users_of(uint32_t material, Side& from, Side& to) {
  const scene::Scene& scene = to.targets.scene;
  for (const User& user : users_of(from, material)) {
    const uint32_t node = same_node(user.node, from, to);
    if (node == kNone || scene.nodes[node].mesh == kNone) continue;
    const scene::Mesh& mesh = scene.meshes[scene.nodes[node].mesh];
    if (user.slot >= mesh.primitive_count) continue;
    const uint32_t found = scene.primitives[mesh.first_primitive + user.slot].material;
    if (scene.materials[found].name == from.targets.scene.materials[material].name) return found;
  }
  return kNone;
}

// Another variant gives primitives other materials.
bool MaterialTransfer::has_same_materials() const {
  const scene::Scene &before = before_.targets.scene, &after = after_.targets.scene;
  return !before.variants.empty() && before.variants == after.variants &&
         before.variant_materials == after.variant_materials &&
         std::ranges::equal(before.materials, after.materials, {}, &scene::Material::name,
                            &scene::Material::name) &&
         std::ranges::equal(before.nodes, after.nodes, {}, &scene::Node::path, &scene::Node::path);
}

uint32_t MaterialTransfer::find(uint32_t material) {
  const scene::Scene &before = before_.targets.scene, &after = after_.targets.scene;
  if (material >= before.materials.size()) return kNone;
  if (!is_same_) is_same_ = has_same_materials();
  if (*is_same_) return material;
  if (const uint32_t found = material_at_users_of(material, before_, after_); found != kNone) return found;
  if (before.materials[material].name.empty()) return kNone;
  const EditKey key = before_.index.key_of(EditedObject::material, material, EditedProperty::factors);
  const uint32_t named = after_.index.find(key);
  if (named == kNone || named >= after.materials.size()) return kNone;
  const uint32_t namesake = material_at_users_of(named, after_, before_);
  return namesake == kNone || namesake == material ? named : kNone;
}

}  // namespace fire3dv::state
