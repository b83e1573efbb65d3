#include "renderer/state/editing/edit_document.h"

#include <utility>

#include "renderer/scene/files.h"

namespace fire3dv::state {
namespace {

// Numbers objects of one name: occurrence_of() counts those before an index, nth_of() finds them again.
template <typename Objects, typename NameOf>
uint32_t occurrence_of(const Objects& objects, uint32_t index, uint32_t first, NameOf&& name_of) {
  uint32_t count = 0;
  for (uint32_t i = first; i < index; ++i) count += name_of(objects[i]) == name_of(objects[index]) ? 1 : 0;
  return count;
}

template <typename Objects, typename NameOf>
uint32_t nth_of(const Objects& objects, const std::string& name, uint32_t occurrence, uint32_t first,
                NameOf&& name_of) {
  for (uint32_t i = first; i < objects.size(); ++i) {
    if (name_of(objects[i]) != name) continue;
    if (occurrence == 0) return i;
    --occurrence;
  }
  return scene::kNone;
}

const std::string& path_of(const scene::Node& node) {
  return node.path;
}
const std::string& name_of_material(const scene::Material& material) {
  return material.name;
}
const std::string& name_of_joint(const robot::RobotJoint& joint) {
  return joint.name;
}

EditKey node_key(uint32_t node, EditedProperty property, const EditTargets& targets) {
  const std::vector<scene::Node>& nodes = targets.scene.nodes;
  const std::string& path = nodes[node].path;
  const uint32_t first = targets.names.first_of_path(path);
  return {EditedObject::node, path, occurrence_of(nodes, node, std::min(first, node), path_of), property};
}

}  // namespace

uint32_t find_target(const EditKey& key, const EditTargets& targets) {
  switch (key.object) {
    case EditedObject::node: {
      const uint32_t first = targets.names.first_of_path(key.name);
      if (first == scene::kNone || key.occurrence == 0) return first;
      return nth_of(targets.scene.nodes, key.name, key.occurrence, first, path_of);
    }
    case EditedObject::material:
      return nth_of(targets.scene.materials, key.name, key.occurrence, 0, name_of_material);
    case EditedObject::joint:
      if (!targets.robot) return scene::kNone;
      return nth_of(targets.robot->robot().joints(), key.name, key.occurrence, 0, name_of_joint);
  }
  return scene::kNone;
}

EditDocument to_document(const UserEdits& edits, const EditTargets& targets) {
  EditDocument document;
  const auto node_count = targets.scene.nodes.size();
  for (const uint32_t node : edits.hidden) {
    if (node < node_count) document.emplace(node_key(node, EditedProperty::visible, targets), false);
  }
  for (const uint32_t node : edits.removed) {
    if (node < node_count) document.emplace(node_key(node, EditedProperty::removed, targets), true);
  }
  for (const auto& [node, transform] : edits.transforms) {
    if (node < node_count) document.emplace(node_key(node, EditedProperty::transform, targets), transform);
  }
  for (const auto& [node, light] : edits.lights) {
    if (node >= node_count) continue;
    scene::Light unnamed = light;  // the name is the file's
    unnamed.name.clear();
    unnamed.is_default = false;
    document.emplace(node_key(node, EditedProperty::light, targets), std::move(unnamed));
  }
  const std::vector<scene::Material>& materials = targets.scene.materials;
  for (const auto& [number, factors] : edits.materials) {
    if (number >= materials.size()) continue;
    const uint32_t occurrence = occurrence_of(materials, number, 0, name_of_material);
    document.emplace(
        EditKey{EditedObject::material, materials[number].name, occurrence, EditedProperty::factors},
        factors);
  }
  if (!targets.robot) return document;
  const auto& joints = targets.robot->robot().joints();
  for (const auto& [joint, position] : edits.joints) {
    if (joint >= joints.size()) continue;
    const uint32_t occurrence = occurrence_of(joints, static_cast<uint32_t>(joint), 0, name_of_joint);
    document.emplace(EditKey{EditedObject::joint, joints[joint].name, occurrence, EditedProperty::position},
                     position);
  }
  return document;
}

UserEdits to_edits(const EditDocument& document, const EditTargets& targets, const UserEdits& view,
                   std::vector<EditKey>* unmatched) {
  UserEdits edits;
  edits.isolated = view.isolated;
  edits.hidden_markers = view.hidden_markers;
  for (const auto& [key, value] : document) {
    const uint32_t target = find_target(key, targets);
    if (target == scene::kNone) {
      if (unmatched) unmatched->push_back(key);
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
    }
  }
  return edits;
}

std::string describe(const EditKey& key) {
  constexpr const char* kObjects[] = {"node", "material", "joint"};
  constexpr const char* kProperties[] = {"the visibility", "the transform", "the light",
                                         "the factors",    "the position",  "the removal"};
  return std::string(kProperties[static_cast<size_t>(key.property)]) + " of " +
         kObjects[static_cast<size_t>(key.object)] + " " + quote(key.name);
}

}  // namespace fire3dv::state
