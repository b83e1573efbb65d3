#include "renderer/state/node_index.h"

#include <algorithm>

namespace fire3dv::state {

NodeNames::NodeNames(const scene::Scene& scene, uint32_t file_nodes) {
  const size_t of_file = std::min<size_t>(scene.nodes.size(), file_nodes);
  file_.by_name.reserve(of_file);
  file_.by_path.reserve(of_file);
  for (uint32_t node = 0; node < scene.nodes.size(); ++node) {
    Layer& layer = node < of_file ? file_ : added_;
    insert(layer.by_name, scene.nodes[node].name, node);
    insert(layer.by_path, scene.nodes[node].path, node);
  }
}

void NodeNames::insert(Index& index, const std::string& name, uint32_t node) {
  if (name.empty()) return;
  const auto [entry, added] = index.try_emplace(name, Entry{node, false});
  if (!added) entry->second.is_shared = true;
}

const NodeNames::Entry* NodeNames::lookup(const Index& index, std::string_view name) {
  const auto entry = index.find(name);
  return entry == index.end() ? nullptr : &entry->second;
}

uint32_t NodeNames::find(std::string_view name) const {
  for (const Layer* layer : {&file_, &added_}) {
    const Entry* const named = lookup(layer->by_name, name);
    if (named && !named->is_shared) return named->first;
    const Entry* const at_path = lookup(layer->by_path, name);
    if (at_path && !at_path->is_shared) return at_path->first;
    if (named || at_path) return scene::kNone;
  }
  return scene::kNone;
}

uint32_t NodeNames::first_of_path(std::string_view path) const {
  for (const Layer* layer : {&file_, &added_}) {
    if (const Entry* const entry = lookup(layer->by_path, path)) return entry->first;
  }
  return scene::kNone;
}

size_t NodeNames::longest_bucket() const {
  size_t longest = 0;
  for (const Index* index : {&file_.by_name, &file_.by_path, &added_.by_name, &added_.by_path}) {
    for (size_t bucket = 0; bucket < index->bucket_count(); ++bucket)
      longest = std::max(longest, index->bucket_size(bucket));
  }
  return longest;
}

}  // namespace fire3dv::state
