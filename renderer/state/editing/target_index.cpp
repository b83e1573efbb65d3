#include "renderer/state/editing/target_index.h"

#include <algorithm>
#include <string>

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

const TargetIndex::Numbers& TargetIndex::numbers_of(EditedObject object) {
  std::optional<Numbers>& numbers = numbers_[static_cast<size_t>(object)];
  if (numbers) return *numbers;
  numbers.emplace();
  for (uint32_t number = 0; number < count_of(object); ++number)
    (*numbers)[name_of(object, number)].push_back(number);
  return *numbers;
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
  if (key.object == EditedObject::node) {
    const uint32_t first = targets_.names.first_of_path(key.name);
    if (first == scene::kNone || key.occurrence == 0) return first;
  }
  const Numbers& numbers = numbers_of(key.object);
  const auto found = numbers.find(std::string_view(key.name));
  if (found == numbers.end() || key.occurrence >= found->second.size()) return scene::kNone;
  return found->second[key.occurrence];
}

EditKey TargetIndex::key_of(EditedObject object, uint32_t number, EditedProperty property) {
  const std::string_view name = name_of(object, number);
  EditKey key{object, std::string(name), 0, property};
  if (object == EditedObject::node && targets_.names.first_of_path(name) == number) return key;
  const std::vector<uint32_t>& same = numbers_of(object).find(name)->second;
  key.occurrence = static_cast<uint32_t>(std::lower_bound(same.begin(), same.end(), number) - same.begin());
  return key;
}

}  // namespace fire3dv::state
