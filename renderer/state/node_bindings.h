// Bindings of streams' names to scene nodes. The oldest stream that claims a node drives it; others conflict.
// Adding or removing a stream costs its own names and the nodes that change drivers. Not thread-safe.
// More than 60 members: names, claims and drivers are one incremental index, changed by each operation.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "protocol/wire/messages.h"
#include "renderer/scene/model/scene.h"
#include "renderer/state/motion/animation.h"
#include "renderer/state/node_index.h"

namespace fire3dv::state {

// Slot of a stream: index of PoseState::streams(). It is stable until the stream is removed, then reused.
using StreamId = uint32_t;
constexpr uint32_t kNone = UINT32_MAX;

// Age of a stream: smaller is older. The upper bits are its rank, the lower 24 bits count its reconnections.
// Streams are compared by rank alone. No two runs have the same age, and none is ever reused.
constexpr uint64_t age_rank(uint64_t age) {
  return age >> 24;
}

// Source of a scene node's transform: world_from_stream(stream) * pose[pose_index] * body_from_node.
// body_from_node includes the rest transforms from the driven ancestor down to this node. stream kNone: the
// node rests, and body_from_node is its world_from_node. The rest pose comes from the file or from animations
// (PoseState::set_rest).
struct NodeDrive {
  uint32_t stream = kNone;
  uint32_t pose_index = 0;
  wire::Affine3x4 body_from_node;
};

// Bindings of one stream. Indices are those of the description's names; see PoseState::names_at().
struct BoundNames {
  IndexSet unmatched_names;                  // no scene node has this name
  IndexSet conflicting_names;                // an older stream drives the node
  IndexSet contested_names;                  // this stream drives the node, and another one requests it
  std::vector<uint32_t> scene_node_of_pose;  // kNone: unmatched or conflicting
};

class NodeBindings {
 public:
  // The owner stores the BoundNames of each stream, by id.
  using BoundNamesOf = std::function<BoundNames&(StreamId)>;
  // The scene must outlive this object, or its replacement by set_scene().
  NodeBindings(const scene::Scene& scene, BoundNamesOf bound_names);

  // Returns a slot without a stream and without a reservation, or the number of slots for a new one.
  // reservation: reservation from suspend(); its slot, if it still exists.
  struct Slot {
    StreamId id = kNone;
    bool is_reserved = false;  // the slot of the reservation, which add() then inherits
  };
  Slot take_slot(uint64_t reservation);
  // Adds a stream to a slot from take_slot(reservation), whose BoundNames are empty sets of the names' size.
  void add(const Slot& slot, uint64_t reservation, const wire::StreamDescription& description);
  // Removes a stream. Its nodes rest, or pass to the next stream that claims them. edited_epoch: its epoch if
  // its edits were applied to the scene, which ends them; nullopt: it has none.
  void remove(StreamId id, std::optional<uint64_t> edited_epoch);
  // Removes a stream, but reserves its age and nodes until expire(until_ns). The youngest reservation expires
  // if there are more than kMaxReservations. Returns the reservation: the stream's age.
  uint64_t suspend(StreamId id, int64_t until_ns, std::optional<uint64_t> edited_epoch);
  static constexpr size_t kMaxReservations = 64;
  // Passes those nodes of the reservation to this stream that it waits for, and ends the reservation's edits.
  void pass_reserved_nodes(uint64_t reservation, StreamId id);
  // Ends the reservations whose time is over.
  void expire(int64_t now_ns);

  // Runs whose edits end, in this order.
  struct EndedEdits {
    StreamId stream = kNone;
    uint64_t epoch = 0;
    uint64_t age = 0;
    bool may_return = false;  // the nodes that it edited stay reserved until another entry of this age
  };
  std::vector<EndedEdits> take_ended_edits() { return std::exchange(ended_edits_, {}); }

  // Replaces the scene. Streams keep their nodes (same index and path, else the first node of the path).
  void set_scene(const scene::Scene& scene, std::optional<uint32_t> file_nodes = std::nullopt);
  const scene::Scene& scene() const { return *scene_; }
  const NodeNames& node_names() const { return node_names_; }
  // Incremented by set_scene(). new_node_of_old() maps nodes of the previous scene to the current one; kNone:
  // the node is gone.
  uint64_t scene_revision() const { return scene_revision_; }
  const std::vector<uint32_t>& new_node_of_old() const { return new_node_of_old_; }

  // Names at these indices, as many as fit into max_bytes (each costs 8 bytes more).
  std::vector<std::string> names_at(StreamId id, const IndexSet& indices, size_t max_bytes) const;
  uint64_t name_lookups() const { return name_lookups_; }

  // Of a stream, as described.
  const std::vector<std::string>& names(StreamId id) const { return slots_[id].names; }
  const std::vector<wire::Affine3x4>& body_from_node(StreamId id) const { return slots_[id].body_from_node; }
  uint64_t age(StreamId id) const { return slots_[id].age; }
  // Age of the stream that drives this node; nullopt: no driver.
  std::optional<uint64_t> age_of_driver(uint32_t node) const;
  uint64_t oldest_age() const;                     // of streams and reservations; UINT64_MAX: there are none
  uint64_t revision() const { return revision_; }  // rises when drivers or ages may have changed
  // See PoseState::driver_changes_since().
  uint64_t driver_revision() const { return driver_changes_begin_ + driver_changes_.size(); }
  std::optional<std::span<const uint32_t>> driver_changes_since(uint64_t revision) const;

  // The stream has a frame: its nodes do not rest any more.
  void begin_driving(StreamId id);
  // Must be called for a new rest pose.
  void rest_changed() { drives_changed(); }
  // One per scene node; rest: of the current scene.
  const std::vector<NodeDrive>& drives(const RestPose& rest) const;
  uint64_t drive_revision() const { return drive_revision_; }  // changes with bindings and rest poses

 private:
  enum class Use : uint8_t { free, stream, reservation };
  struct Entry {
    Use use = Use::free;
    uint64_t age = 0;
    bool is_driving = false;  // its poses move its nodes
    // kNone: unmatched. Of a reservation: its nodes, which it drives with pose kNone.
    std::vector<uint32_t> node_of_pose;
    std::vector<std::string> names;
    std::vector<std::pair<uint64_t, uint32_t>> poses_by_hash;  // of names; built on demand
    std::vector<wire::Affine3x4> body_from_node;               // empty, one for all, or one per pose
  };
  // A name whose node another stream drives. The oldest claim gets the node next.
  struct Claim {
    uint32_t node = kNone;
    uint64_t age = 0;
    uint32_t pose = 0;
    StreamId stream = kNone;
    auto operator<=>(const Claim&) const = default;
  };
  // Reservation of a suspended stream.
  struct Reservation {
    uint64_t age = 0;
    int64_t until_ns = 0;
    StreamId slot = kNone;  // holds the nodes; kNone: returned, and only its edits are reserved
    std::optional<uint64_t> edited_epoch;
  };
  struct ChangedName {
    uint64_t hash = 0;
    std::string_view name;
  };
  std::vector<Reservation>::iterator find_reservation(uint64_t age);
  void end_reservation(const Reservation& reservation);
  void add_reservation(const Reservation& reservation);
  void bind(StreamId id, uint32_t pose, uint32_t node);
  void set_driver(StreamId id, uint32_t pose, uint32_t node);
  void release_node(uint32_t node);
  void drop_claim(StreamId id, uint32_t pose, uint32_t node);
  void drop_claims(StreamId id);
  bool is_contested(uint32_t node, StreamId driver) const;
  std::vector<ChangedName> find_changed_names(const scene::Scene& before) const;
  void bind_unmatched(StreamId id, const std::vector<ChangedName>& changed);
  std::vector<StreamId> clear_bindings(std::vector<BoundNames>& before);
  void restore_drivers(const std::vector<uint32_t>& drivers, const std::vector<uint32_t>& driver_poses);
  void record_driver_change(uint32_t node);
  void reset_driver_changes();
  void bindings_changed();
  void drives_changed();

  const scene::Scene* scene_;
  uint32_t file_nodes_;  // leading nodes, of the file
  BoundNamesOf bound_names_;
  NodeNames node_names_;
  uint64_t scene_revision_ = 0;
  std::vector<uint32_t> new_node_of_old_;
  std::vector<Entry> slots_;
  uint64_t next_rank_ = 1;
  std::vector<Reservation> reservations_;
  std::vector<EndedEdits> ended_edits_;
  std::vector<uint32_t> driver_stream_of_node_, driver_pose_of_node_;
  std::set<Claim> claims_;
  uint64_t driver_changes_begin_ = 0;  // revision of the first of:
  std::vector<uint32_t> driver_changes_;
  mutable std::vector<NodeDrive> drives_;  // derived on access
  mutable bool are_drives_stale_ = true;
  uint64_t name_lookups_ = 0;
  uint64_t drive_revision_ = 0, revision_ = 0;
};

}  // namespace fire3dv::state
