#include "renderer/state/marker_registry.h"

#include <algorithm>
#include <iterator>
#include <variant>

#include "base/log.h"
#include "base/text.h"
#include "renderer/scene/model/math.h"
#include "renderer/state/draw_time/draw_work.h"

namespace fire3dv::state {
namespace {

constexpr uint32_t kMaxReported = 8;  // per stream

// The buffer of all markers has up to twice their size, so that a changed one seldom moves the others.
uint64_t gpu_bytes(const wire::Marker& marker) {
  const uint64_t bytes = marker.positions.size() * sizeof marker.positions[0] +
                         marker.rotations.size() * sizeof marker.rotations[0] +
                         marker.sizes.size() * sizeof marker.sizes[0] +
                         marker.colors.size() * sizeof marker.colors[0];
  constexpr uint64_t kGlyphBytes = 12 + 2 * 16 + 4;  // position, two rectangles, colour
  const uint64_t texels = uint64_t{4} * marker.image.width * marker.image.height;
  return 2 * (marker.kind == wire::MarkerKind::texts ? kGlyphBytes * text_bytes(marker) : bytes + texels);
}

// A small element of many vertices is a cheap message and an expensive draw. 200 million take an NVIDIA H200
// a fraction of a second.
constexpr uint64_t kMaxVertices = 200'000'000;  // of a stream

bool is_marker(const wire::SceneEdit& edit) {
  return edit.property == wire::Property::marker;
}

// Also right where the sum of both times would overflow.
bool includes(const wire::Marker& marker, int64_t sim_time_ns) {
  return sim_time_ns >= marker.sim_time_ns &&
         static_cast<uint64_t>(sim_time_ns) - static_cast<uint64_t>(marker.sim_time_ns) <= marker.lifetime_ns;
}

bool is_finite(const glm::mat4& matrix) {
  float sum = 0;
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row) sum += 0 * matrix[column][row];
  return sum == 0;
}

}  // namespace

std::string_view namespace_of(std::string_view marker_name) {
  const size_t slash = marker_name.find('/');
  return slash == marker_name.npos ? std::string_view() : marker_name.substr(0, slash);
}

bool MarkerRegistry::take_from(std::vector<SceneChanges>& changes) {
  bool is_changed = false;
  for (SceneChanges& change : changes) {
    if (change.ended) {
      is_changed |= streams_.erase(change.age) != 0;
      continue;
    }
    if (std::none_of(change.edits.begin(), change.edits.end(), is_marker)) continue;
    std::vector<wire::SceneEdit> others;
    std::vector<BudgetCharge> charges;
    for (size_t i = 0; i < change.edits.size(); ++i) {
      BudgetCharge charge = i < change.charges.size() ? std::move(change.charges[i]) : BudgetCharge();
      if (!is_marker(change.edits[i])) {
        others.push_back(std::move(change.edits[i]));
        charges.push_back(std::move(charge));
        continue;
      }
      StreamEntry& stream = streams_[change.age];
      stream.id = change.stream;
      stream.epoch = change.epoch;
      stream.budget = change.budget;
      store(stream, std::move(change.edits[i]), std::move(charge), change.budget);
      is_changed = true;
      if (stream.markers.empty() && stream.reported == 0) streams_.erase(change.age);
    }
    change.edits = std::move(others);
    change.charges = std::move(charges);
  }
  if (is_changed)
    std::erase_if(changes, [](const SceneChanges& change) { return !change.ended && change.edits.empty(); });
  return is_changed;
}

void MarkerRegistry::store(StreamEntry& stream, wire::SceneEdit&& edit, BudgetCharge charge,
                           const std::shared_ptr<PeerBudget>& budget) {
  if (const auto known = stream.markers.find(edit.node); known != stream.markers.end()) {
    stream.vertices -= known->second.vertices;
    const auto count = stream.namespaces.find(namespace_of(known->first));
    if (--count->second == 0) stream.namespaces.erase(count);
    stream.markers.erase(known);  // its charges must not count against the new value
  }
  auto* value = std::get_if<wire::Marker>(&edit.value);
  if (!value) return;
  if (static_cast<size_t>(value->kind) >= wire::kMarkerKindCount)
    return report(stream, edit.node,
                  "its kind " + std::to_string(static_cast<int>(value->kind)) +
                      " is of a later version: update the renderer");
  const uint64_t vertices = max_marker_vertices(*value);
  if (stream.vertices + vertices > kMaxVertices)
    return report(
        stream, edit.node,
        "the markers of this stream would draw more than " + std::to_string(kMaxVertices) + " vertices");
  Result<BudgetCharge> gpu = BudgetCharge::take(budget, Resource::gpu_bytes, gpu_bytes(*value));
  if (!gpu) return report(stream, edit.node, gpu.error().message);
  ++stream.namespaces[std::string(namespace_of(edit.node))];
  MarkerInForce& entry = stream.markers[edit.node];
  entry.id = ++last_id_;
  entry.marker = std::make_shared<const wire::Marker>(std::move(*value));
  entry.value = std::move(charge);
  entry.gpu = std::move(*gpu);
  entry.vertices = vertices;
  stream.vertices += vertices;
}

void MarkerRegistry::report(StreamEntry& stream, const std::string& name, const std::string& reason) {
  if (++stream.reported > kMaxReported) return;
  log_messages_.push_back(
      warning("the marker " + quote(name) + " is not shown: " + reason +
              (stream.reported == kMaxReported ? "; further markers are not logged" : "")));
}

// Returns false if the scene has no such node.
bool MarkerRegistry::find_parent(const PoseState& poses, MarkerInForce& entry) {
  if (std::exchange(entry.scene_revision, poses.scene_revision()) != poses.scene_revision())
    entry.parent_node = poses.names().find(entry.marker->parent);
  return entry.parent_node != kNone;
}

const std::map<std::string, size_t, std::less<>>& MarkerRegistry::namespaces(uint64_t epoch) const {
  static const std::map<std::string, size_t, std::less<>> kEmpty;
  for (const auto& [age, entry] : streams_)
    if (entry.epoch == epoch) return entry.namespaces;
  return kEmpty;
}

const std::vector<ShownMarker>& MarkerRegistry::resolve(const PoseState& poses,
                                                        const scene::SceneEdits& edits, bool complete,
                                                        const MarkerNamespaces& hidden) {
  shown_.clear();
  held_back_.clear();
  for (auto& [age, entry] : streams_) {
    if (entry.id >= poses.streams().size()) continue;
    const Stream& stream = poses.streams()[entry.id];
    if (!stream.active || stream.epoch != entry.epoch) continue;
    hidden_.clear();
    for (auto of_stream = hidden.lower_bound({stream.name, ""});
         of_stream != hidden.end() && of_stream->stream == stream.name; ++of_stream)
      hidden_.push_back(of_stream->name);
    std::vector<ShownMarker>& list = hidden_peers_.contains(entry.budget.get()) ? held_back_ : shown_;
    for (auto& [name, in_force] : entry.markers) {
      if (std::ranges::binary_search(hidden_, namespace_of(name))) continue;
      const wire::Marker& marker = *in_force.marker;
      if (marker.positions.empty()) continue;
      if (marker.lifetime_ns != 0 &&
          (stream.header.sequence == 0 || !includes(marker, stream.header.sim_time_ns)))
        continue;
      glm::dmat4 world_from_parent;
      if (marker.parent.empty()) {
        world_from_parent = scene::to_dmat4(stream.world_from_stream);
      } else if (!find_parent(poses, in_force)) {
        if (complete && !std::exchange(entry.reported_parent, true))
          report(entry, name, "no scene node is called " + quote(marker.parent));
        continue;
      } else {
        if (edits.is_hidden(in_force.parent_node)) continue;
        world_from_parent = glm::dmat4(poses.world_from_node(in_force.parent_node));
      }
      const glm::mat4 world_from_marker(world_from_parent *
                                        glm::dmat4(scene::to_mat4(marker.parent_from_marker)));
      if (is_finite(world_from_marker))
        list.push_back({in_force.id, in_force.marker, world_from_marker, entry.budget.get()});
    }
  }
  return shown_;
}

}  // namespace fire3dv::state
