// Index of the objects that edit keys name, for many look-ups in one scene. It is built when a key first
// needs it: most keys name the first node of their path, which the scene's names know.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "base/random.h"
#include "renderer/editing/edit_document.h"

namespace fire3dv::state {

class TargetIndex {
 public:
  // The targets outlive this object.
  explicit TargetIndex(const EditTargets& targets) : targets_(targets) {}

  // Number of the object, 0 for additions; scene::kNone: the scene has none of that name.
  uint32_t find(const EditKey& key);
  // The same; of the scene the number of the variant.
  uint32_t find(const EditKey& key, const EditedValue& value);
  // Key of an existing object.
  EditKey key_of(EditedObject object, uint32_t number, EditedProperty property);

 private:
  using Numbers = std::unordered_map<std::string_view, std::vector<uint32_t>, KeyedHash, std::equal_to<>>;
  const Numbers& numbers_of(EditedObject object, std::string_view owner);
  std::string_view name_of(EditedObject object, uint32_t number) const;
  uint32_t count_of(EditedObject object) const;
  std::string_view owner_of(EditedObject object, uint32_t number) const;
  uint32_t anchor_of(uint32_t node) const;
  std::span<const uint32_t> without_path(uint32_t anchor);
  EditKey key_without_path(uint32_t node, EditedProperty property);

  const EditTargets& targets_;
  std::array<std::optional<std::map<std::string_view, Numbers>>, 5> numbers_;  // by object, then by owner
  std::optional<std::vector<uint32_t>> without_path_;                          // nodes, by their anchors
};

// Message about an edit whose object the scene lacks.
std::string missing_target_text(const EditKey& key, const EditTargets& targets);

}  // namespace fire3dv::state
