// Document of the user's edits, independent of the numbers of a loaded scene: values by the name of the
// edited object and the property. It is what undo steps change and what an overlay file stores. View
// settings, such as isolation, are no part of it.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <variant>
#include <vector>

#include "renderer/scene/model/scene.h"
#include "renderer/state/edits/user_edits.h"
#include "renderer/state/node_index.h"

namespace fire3dv::state {

// An addition is of the user, so that a scene need not have it.
enum class EditedObject : uint8_t { node, material, joint, scene, addition };
enum class EditedProperty : uint8_t { visible, transform, light, factors, position, removed, variant, added };

// Objects of one name are numbered in the order of the scene, materials within their file: what is added or
// missing elsewhere changes no key.
struct EditKey {
  EditedObject object = EditedObject::node;
  std::string name;         // path of a node; name of a material, joint or addition; empty for the scene
  uint32_t occurrence = 0;  // 0: the first object of the name
  EditedProperty property = EditedProperty::visible;
  std::string owner = {};  // of a material: name of the added node with its file; empty: the scene's file
  std::optional<uint32_t> instance = {};  // number among the nodes without a path below the named one

  auto by_object() const { return std::tie(object, owner, name, occurrence, instance, property); }
  std::strong_ordering operator<=>(const EditKey& other) const { return by_object() <=> other.by_object(); }
  bool operator==(const EditKey& other) const { return by_object() == other.by_object(); }
  // Another property of the same object; a document has them one after the other.
  bool has_object_of(const EditKey& other) const {
    return object == other.object && owner == other.owner && name == other.name &&
           occurrence == other.occurrence && instance == other.instance;
  }
};

using JointPosition = std::vector<double>;  // as in JointPositions
using VariantName = std::string;            // of a material variant
// Visibility or removal, transform, light, factors, position, variant and addition; the value belongs to the
// key's property.
using EditedValue = std::variant<bool, NodeTransform, scene::Light, scene::MaterialFactors, JointPosition,
                                 VariantName, Addition>;
using EditDocument = std::map<EditKey, EditedValue>;
// Key of the scene's material variant.
inline EditKey variant_key() {
  return {EditedObject::scene, {}, 0, EditedProperty::variant};
}

// Objects that keys name. Borrowed for a call.
struct EditTargets {
  const scene::Scene& scene;
  const NodeNames& names;                      // of the scene
  const RobotPose* robot = nullptr;            // null: the scene has no joints
  std::span<const AddedMaterials> added = {};  // in the order of the materials; all others are the file's
};

// Number of the object, 0 for additions; scene::kNone: the scene has none of that name.
uint32_t find_target(const EditKey& key, const EditTargets& targets);

EditDocument to_document(const UserEdits& edits, const EditTargets& targets);
// Edits of the objects that exist; the view settings are those of `view`. unmatched: receives the keys of
// others, with the name of a missing variant; null: not wanted.
UserEdits to_edits(const EditDocument& document, const EditTargets& targets, const UserEdits& view,
                   std::vector<EditKey>* unmatched = nullptr);

// Text for messages, such as: the transform of node "arm".
std::string describe(const EditKey& key);

}  // namespace fire3dv::state
