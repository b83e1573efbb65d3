#include "renderer/editing/target_index.h"

#include <algorithm>
#include <iterator>

namespace fire3dv::state {

std::string_view TargetIndex::name_of(EditedObject object, uint32_t number) const {
  switch (object) {
    case EditedObject::node:
      return targets_.scene.nodes[number].path;
    case EditedObject::material:
      return targets_.scene.materials[number].name;
    case EditedObject::scene:
      return {};
    case EditedObject::joint:
    case EditedObject::addition:
      break;
  }
  return targets_.robot->robot().joints()[number].name;
}

uint32_t TargetIndex::count_of(EditedObject object) const {
  switch (object) {
    case EditedObject::node:
      return static_cast<uint32_t>(targets_.scene.nodes.size());
    case EditedObject::material:
      return static_cast<uint32_t>(targets_.scene.materials.size());
    case EditedObject::scene:
      return 1;
    case EditedObject::joint:
    case EditedObject::addition:
      break;
  }
  return targets_.robot ? static_cast<uint32_t>(targets_.robot->robot().joints().size()) : 0;
}

std::string_view TargetIndex::owner_of(EditedObject object, uint32_t number) const {
  if (object != EditedObject::material) return {};
  const auto next = std::ranges::upper_bound(targets_.added, number, {}, &AddedMaterials::first);
  if (next == targets_.added.begin()) return {};
  const AddedMaterials& added = *std::prev(next);
  return number - added.first < added.count ? std::string_view(added.owner) : std::string_view();
}

const TargetIndex::Numbers& TargetIndex::numbers_of(EditedObject object, std::string_view owner) {
  auto& numbers = numbers_[static_cast<size_t>(object)];
  if (!numbers) {
    numbers.emplace();
    for (uint32_t number = 0; number < count_of(object); ++number)
      (*numbers)[owner_of(object, number)][name_of(object, number)].push_back(number);
  }
  static const Numbers kNothing;
  const auto found = numbers->find(owner);
  return found == numbers->end() ? kNothing : found->second;
}

// Instances, and roots of files without a name, have no path. kNone: it is such a root of the scene.
uint32_t TargetIndex::anchor_of(uint32_t node) const {
  const std::vector<scene::Node>& nodes = targets_.scene.nodes;
  uint32_t anchor = nodes[node].parent;
  while (anchor != scene::kNone && nodes[anchor].path.empty() && nodes[anchor].parent != scene::kNone)
    anchor = nodes[anchor].parent;
  return anchor;
}

std::span<const uint32_t> TargetIndex::without_path(uint32_t anchor) {
  const auto by_anchor = [&](uint32_t node) { return anchor_of(node); };
  if (!without_path_) {
    without_path_.emplace();
    for (uint32_t node = 0; node < targets_.scene.nodes.size(); ++node) {
      if (targets_.scene.nodes[node].path.empty()) without_path_->push_back(node);
    }
    std::ranges::stable_sort(*without_path_, {}, by_anchor);
  }
  const auto found = std::ranges::equal_range(*without_path_, anchor, {}, by_anchor);
  return {found.begin(), found.end()};
}

EditKey TargetIndex::key_without_path(uint32_t node, EditedProperty property) {
  const uint32_t anchor = anchor_of(node);
  const std::span<const uint32_t> all = without_path(anchor);
  const auto number = static_cast<uint32_t>(std::ranges::lower_bound(all, node) - all.begin());
  if (anchor == scene::kNone) return {EditedObject::node, {}, number, property};
  EditKey key = key_of(EditedObject::node, anchor, property);
  key.instance = number;
  return key;
}

uint32_t TargetIndex::find(const EditKey& key, const EditedValue& value) {
  const auto* variant = std::get_if<VariantName>(&value);
  if (!variant) return find(key);
  const std::vector<std::string>& variants = targets_.scene.variants;
  const auto found = std::find(variants.begin(), variants.end(), *variant);
  return found == variants.end() ? scene::kNone : static_cast<uint32_t>(found - variants.begin());
}

uint32_t TargetIndex::find(const EditKey& key) {
  if (key.object == EditedObject::addition) return 0;
  if (key.instance) {
    EditKey of_node = key;
    of_node.instance.reset();
    const uint32_t anchor = find(of_node);
    if (anchor == scene::kNone) return scene::kNone;
    const std::span<const uint32_t> all = without_path(anchor);
    return *key.instance < all.size() ? all[*key.instance] : scene::kNone;
  }
  if (key.object == EditedObject::node && key.name.empty()) {
    const std::span<const uint32_t> roots = without_path(scene::kNone);
    return key.occurrence < roots.size() ? roots[key.occurrence] : scene::kNone;
  }
  if (key.object == EditedObject::node) {
    const uint32_t first = targets_.names.first_of_path(key.name);
    if (first == scene::kNone || key.occurrence == 0) return first;
  }
  const Numbers& numbers = numbers_of(key.object, key.owner);
  const auto found = numbers.find(std::string_view(key.name));
  if (found == numbers.end() || key.occurrence >= found->second.size()) return scene::kNone;
  return found->second[key.occurrence];
}

EditKey TargetIndex::key_of(EditedObject object, uint32_t number, EditedProperty property) {
  const std::string_view name = name_of(object, number);
  if (object == EditedObject::node && name.empty()) return key_without_path(number, property);
  const std::string_view owner = owner_of(object, number);
  EditKey key{object, std::string(name), 0, property, std::string(owner)};
  if (object == EditedObject::node && targets_.names.first_of_path(name) == number) return key;
  const std::vector<uint32_t>& same = numbers_of(object, owner).find(name)->second;
  key.occurrence = static_cast<uint32_t>(std::lower_bound(same.begin(), same.end(), number) - same.begin());
  return key;
}

std::string missing_target_text(const EditKey& key, const EditTargets& targets) {
  const bool may_be_of_added =
      key.object == EditedObject::material && key.owner.empty() && !targets.added.empty();
  const char* const have = key.property == EditedProperty::factors ? " have" : " has";
  return describe(key) + have + " no effect: the scene" +
         (may_be_of_added
              ? "'s file has no such object; for one of an added file, name that file's node (\"of\")"
              : " has no such object now");
}

}  // namespace fire3dv::state
