#include "renderer/state/bindings.h"

namespace fire3dv::state {

NodeNames::NodeNames(const scene::Scene& scene) {
  for (uint32_t node = 0; node < scene.nodes.size(); ++node) {
    insert(by_name_, scene.nodes[node].name, node);
    insert(by_path_, scene.nodes[node].path, node);
  }
}

void NodeNames::insert(Index& index, const std::string& name, uint32_t node) {
  if (name.empty()) return;
  const auto [entry, added] = index.try_emplace(name, node);
  if (!added) entry->second = scene::kNone;
}

uint32_t NodeNames::lookup(const Index& index, std::string_view name) {
  const auto entry = index.find(name);
  return entry == index.end() ? scene::kNone : entry->second;
}

uint32_t NodeNames::find(std::string_view name) const {
  const uint32_t node = lookup(by_name_, name);
  return node != scene::kNone ? node : lookup(by_path_, name);
}

}  // namespace fire3dv::state
