#include "renderer/editing/edit_document.h"

#include <utility>

#include "base/text.h"
#include "renderer/editing/target_index.h"

namespace fire3dv::state {
uint32_t find_target(const EditKey& key, const EditTargets& targets) {
  return TargetIndex(targets).find(key);
}

EditDocument to_document(const UserEdits& edits, const EditTargets& targets) {
  EditDocument document;
  TargetIndex index(targets);
  const auto node_count = targets.scene.nodes.size();
  for (const uint32_t node : edits.hidden) {
    if (node < node_count)
      document.emplace(index.key_of(EditedObject::node, node, EditedProperty::visible), false);
  }
  for (const uint32_t node : edits.removed) {
    if (node < node_count)
      document.emplace(index.key_of(EditedObject::node, node, EditedProperty::removed), true);
  }
  for (const auto& [node, transform] : edits.transforms) {
    if (node < node_count)
      document.emplace(index.key_of(EditedObject::node, node, EditedProperty::transform), transform);
  }
  for (const auto& [node, light] : edits.lights) {
    if (node >= node_count) continue;
    scene::Light unnamed = light;  // the name is the file's
    unnamed.name.clear();
    unnamed.is_default = false;
    document.emplace(index.key_of(EditedObject::node, node, EditedProperty::light), std::move(unnamed));
  }
  for (const auto& [number, factors] : edits.materials) {
    if (number < targets.scene.materials.size())
      document.emplace(index.key_of(EditedObject::material, number, EditedProperty::factors), factors);
  }
  if (edits.variant < targets.scene.variants.size())
    document.emplace(variant_key(), targets.scene.variants[edits.variant]);
  for (const auto& [name, addition] : edits.additions)
    document.emplace(EditKey{EditedObject::addition, name, 0, EditedProperty::added}, addition);
  if (!targets.robot) return document;
  for (const auto& [joint, position] : edits.joints) {
    if (joint >= targets.robot->robot().joints().size()) continue;
    const auto number = static_cast<uint32_t>(joint);
    document.emplace(index.key_of(EditedObject::joint, number, EditedProperty::position), position);
  }
  return document;
}

UserEdits to_edits(const EditDocument& document, const EditTargets& targets, const UserEdits& view,
                   std::vector<EditKey>* unmatched) {
  UserEdits edits;
  edits.isolated = view.isolated;
  edits.hidden_markers = view.hidden_markers;
  TargetIndex index(targets);
  for (const auto& [key, value] : document) {
    const uint32_t target = index.find(key, value);
    const auto* variant = std::get_if<VariantName>(&value);
    if (target == scene::kNone) {
      if (unmatched) unmatched->push_back(key);
      if (unmatched && variant) unmatched->back().name = *variant;
      continue;
    }
    if (const auto* flag = std::get_if<bool>(&value)) {
      if (key.property == EditedProperty::visible && !*flag) edits.hidden.insert(target);
      if (key.property == EditedProperty::removed && *flag) edits.removed.insert(target);
    } else if (const auto* transform = std::get_if<NodeTransform>(&value)) {
      edits.transforms[target] = *transform;
    } else if (const auto* light = std::get_if<scene::Light>(&value)) {
      scene::Light& edited = edits.lights[target] = *light;
      if (const uint32_t own = targets.scene.nodes[target].light; own < targets.scene.lights.size()) {
        edited.name = targets.scene.lights[own].name;
        edited.is_default = targets.scene.lights[own].is_default;
      }
    } else if (const auto* factors = std::get_if<scene::MaterialFactors>(&value)) {
      edits.materials[target] = *factors;
    } else if (const auto* position = std::get_if<JointPosition>(&value)) {
      edits.joints[target] = *position;
    } else if (const auto* addition = std::get_if<Addition>(&value)) {
      edits.additions[key.name] = *addition;
    } else if (variant) {
      edits.variant = target;
    }
  }
  return edits;
}

std::string describe(const EditKey& key) {
  if (key.property == EditedProperty::variant)
    return "the material variant" + (key.name.empty() ? key.name : " " + quote(key.name));
  constexpr const char* kObjects[] = {"node", "material", "joint", "scene", "node"};
  constexpr const char* kProperties[] = {"the visibility", "the transform", "the light",   "the factors",
                                         "the position",   "the removal",   "the variant", "the addition"};
  const std::string instance = key.instance ? "instance " + std::to_string(*key.instance) + " of " : "";
  return std::string(kProperties[static_cast<size_t>(key.property)]) + " of " + instance +
         kObjects[static_cast<size_t>(key.object)] + " " + quote(key.name) +
         (key.owner.empty() ? "" : " of " + quote(key.owner));
}

}  // namespace fire3dv::state
