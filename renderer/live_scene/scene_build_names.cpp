#include "renderer/live_scene/scene_build_names.h"

namespace fire3dv::app {

uint32_t PendingNames::find_parent(const std::string& parent) {
  ++lookups_;
  const uint32_t node = base_.find(parent);
  if (node != scene::kNone) return node;
  const auto known = parents_.find(parent);
  if (known == parents_.end()) return scene::kNone;
  if (known->second.by_name != scene::kNone) return known->second.by_name;
  return known->second.path_is_ambiguous ? scene::kNone : known->second.by_path;
}

uint32_t PendingNames::find_path(const std::string& path, const scene::Scene& scene) {
  ++lookups_;
  uint32_t node = base_.find(path);
  // Names come first there, and one may look like the path of another node.
  if (node != scene::kNone && scene.nodes[node].path != path) node = base_.first_of_path(path);
  if (node != scene::kNone) return node;
  const auto known = parents_.find(path);
  const bool is_known = known != parents_.end() && !known->second.path_is_ambiguous;
  return is_known ? known->second.by_path : scene::kNone;
}

bool PendingNames::is_taken(const std::string& name) const {
  return base_.find(name) != scene::kNone || names_and_paths_.contains(name);
}

void PendingNames::add(const std::string* name, const std::string& path, uint32_t index,
                       std::vector<size_t>& ready) {
  const auto tell = [&](const std::string& text, bool is_name) {
    if (text.empty()) return;
    names_and_paths_.insert(text);
    const auto parent = parents_.find(text);
    if (parent == parents_.end()) return;
    Parent& found = parent->second;
    if (is_name) {
      found.by_name = index;
    } else {
      found.path_is_ambiguous |= found.by_path != scene::kNone;
      found.by_path = index;
    }
    ready.insert(ready.end(), found.waiting.begin(), found.waiting.end());
    found.waiting.clear();
  };
  tell(path, false);
  if (name) tell(*name, true);
}

}  // namespace fire3dv::app
