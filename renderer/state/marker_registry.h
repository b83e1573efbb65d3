// Registry of markers in force: the newest value of each name while its stream lasts. Markers are not bound
// to nodes as other edits are; their parents are resolved to poses for each image. Not thread-safe.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/peer_budget.h"
#include "protocol/wire/marker.h"
#include "protocol/wire/scene_edit.h"
#include "renderer/scene/model/scene_edits.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::state {

// Markers of one stream whose names begin with "name/"; with an empty name, those without a namespace.
struct MarkerNamespace {
  std::string stream;  // its name, which it keeps when the simulator starts again
  std::string name;
  auto operator<=>(const MarkerNamespace&) const = default;
};
using MarkerNamespaces = std::set<MarkerNamespace>;

// The part of a marker's name before its first "/"; empty without one.
std::string_view namespace_of(std::string_view marker_name);

// Marker of one image.
struct ShownMarker {
  uint64_t id = 0;  // of the value: markers with equal ids have equal values
  std::shared_ptr<const wire::Marker> marker;
  glm::mat4 world_from_marker{1};
  const PeerBudget* peer = nullptr;  // identity of its sender; null: no peer
};

class MarkerRegistry {
 public:
  // Removes the marker edits, with their charges, from the changes of PoseState::take_scene_changes(), and
  // those changes that hold no others. Returns true if a marker changed.
  bool take_from(std::vector<SceneChanges>& changes);

  // Markers of the poses shown now, the oldest stream first, by name: without those whose lifetime does not
  // include the shown frame, and whose parent is hidden or absent. complete: all requested nodes have been
  // added or refused, so that absent parents are reported. hidden: left out. Valid until the next call.
  const std::vector<ShownMarker>& resolve(const PoseState& poses, const scene::SceneEdits& edits,
                                          bool complete = true, const MarkerNamespaces& hidden = {});

  // Markers of these peers are left out by resolve(), and listed here instead.
  void set_hidden_peers(std::set<const PeerBudget*> peers) { hidden_peers_ = std::move(peers); }
  const std::vector<ShownMarker>& held_back() const { return held_back_; }
  // The result of the last resolve().
  const std::vector<ShownMarker>& shown() const { return shown_; }

  // Numbers of markers in force, by namespace, of the stream with this epoch. Valid until the next change.
  const std::map<std::string, size_t, std::less<>>& namespaces(uint64_t epoch) const;

  bool empty() const { return streams_.empty(); }
  // Log messages since the last call.
  std::vector<std::string> take_log_messages() { return std::exchange(log_messages_, {}); }

 private:
  struct MarkerInForce {
    uint64_t id = 0;
    std::shared_ptr<const wire::Marker> marker;
    BudgetCharge value, gpu;
    uint64_t vertices = 0;         // at most, of its draw
    uint32_t parent_node = kNone;  // of the scene of scene_revision
    uint64_t scene_revision = UINT64_MAX;
  };
  struct StreamEntry {
    StreamId id = kNone;
    uint64_t epoch = 0;
    std::shared_ptr<PeerBudget> budget;
    std::map<std::string, MarkerInForce> markers;
    std::map<std::string, size_t, std::less<>> namespaces;  // numbers of markers
    uint64_t vertices = 0;                                  // of all
    uint32_t reported = 0;
    bool reported_parent = false;
  };
  void store(StreamEntry& stream, wire::SceneEdit&& edit, BudgetCharge charge,
             const std::shared_ptr<PeerBudget>& budget);
  void report(StreamEntry& stream, const std::string& name, const std::string& reason);
  bool find_parent(const PoseState& poses, MarkerInForce& entry);

  std::map<uint64_t, StreamEntry> streams_;  // by age, the oldest first
  uint64_t last_id_ = 0;
  std::vector<ShownMarker> shown_, held_back_;
  std::set<const PeerBudget*> hidden_peers_;
  std::vector<std::string_view> hidden_;  // namespaces of one stream, sorted; of resolve()
  std::vector<std::string> log_messages_;
};

}  // namespace fire3dv::state
