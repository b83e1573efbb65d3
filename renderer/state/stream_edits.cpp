#include "renderer/state/stream_edits.h"

#include <algorithm>

namespace fire3dv::state {
namespace {

size_t bytes_of(const wire::SceneEdit& edit) {
  size_t bytes = sizeof edit + edit.node.size();
  if (const auto* node = std::get_if<wire::NodeAdded>(&edit.value))
    bytes += node->parent.size() + node->asset_uri.size() + node->asset_glb.size();
  if (const auto* vertices = std::get_if<wire::Vertices>(&edit.value))
    bytes += (vertices->positions.size() + vertices->normals.size()) * sizeof vertices->positions[0];
  return bytes;
}

// The scene has to be made anew for it.
bool takes_long(const wire::SceneEdit& edit) {
  return std::holds_alternative<wire::NodeAdded>(edit.value) ||
         std::holds_alternative<wire::Vertices>(edit.value);
}

}  // namespace

StreamEdits::Outcome StreamEdits::add(wire::SceneEdit&& edit) {
  if (edit.version <= received_) return Outcome::stale;
  received_ = edit.version;
  Key key(edit.node, edit.property);
  if (keys_.size() >= limits_.keys && !keys_.contains(key)) return Outcome::refused;
  const auto replaced = waiting_.find(key);
  const size_t freed = replaced == waiting_.end() ? 0 : bytes_of(replaced->second);
  const size_t bytes = bytes_of(edit);
  if (waiting_bytes_ - freed + bytes > limits_.waiting_bytes) return Outcome::refused;
  // What is replaced before anybody saw it will never be loaded.
  if (replaced != waiting_.end()) loading_.erase(replaced->second.version);
  if (load_aside_ && takes_long(edit)) loading_.insert(edit.version);
  waiting_bytes_ += bytes - freed;
  keys_.insert(key);
  waiting_.insert_or_assign(std::move(key), std::move(edit));
  return Outcome::taken;
}

StreamEdits::Outcome StreamEdits::skip(uint64_t version) {
  if (version <= received_) return Outcome::stale;
  received_ = version;
  return Outcome::taken;
}

std::vector<wire::SceneEdit> StreamEdits::take() {
  std::vector<wire::SceneEdit> edits;
  edits.reserve(waiting_.size());
  for (auto& [key, edit] : waiting_) edits.push_back(std::move(edit));
  std::sort(edits.begin(), edits.end(), [](const auto& a, const auto& b) { return a.version < b.version; });
  waiting_.clear();
  waiting_bytes_ = 0;
  was_taken_ = was_taken_ || !edits.empty();
  return edits;
}

}  // namespace fire3dv::state
