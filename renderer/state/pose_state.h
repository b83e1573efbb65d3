// Pose state: newest whole frame of each stream and its binding to scene nodes. It has no sockets and no
// Vulkan, so that live links, in-process replay and recordings share it. One thread; times in nanoseconds on
// the local monotonic clock.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/base/peer_budget.h"
#include "protocol/stream/frame_assembler.h"
#include "protocol/wire/messages.h"
#include "renderer/scene/model/scene.h"
#include "renderer/state/animation.h"
#include "renderer/state/bindings.h"
#include "renderer/state/frame_queue.h"
#include "renderer/state/index_set.h"
#include "renderer/state/liveness.h"
#include "renderer/state/playout/playout.h"
#include "renderer/state/stream_edits.h"

namespace fire3dv::state {

// Index of PoseState::streams(). It is stable until the stream is removed, then reused.
using StreamId = uint32_t;
constexpr uint32_t kNone = UINT32_MAX;

// Age of a stream: smaller is older. The upper bits are its rank, the lower 24 bits count its reconnections.
// Streams are compared by rank alone.
constexpr uint64_t age_rank(uint64_t age) {
  return age >> 24;
}

// Provenance tag of an image: the pose frame of one stream that it shows. It accompanies the image to its
// sink.
struct FrameTag {
  std::string stream;  // the adapter's name
  uint64_t epoch = 0;
  uint64_t sequence = 0;
  int64_t sim_time_ns = 0;
  uint64_t publish_time_ns = 0;  // on the publisher's monotonic clock
  Condition condition = Condition::live;
};

// Source of a scene node's transform: world_from_stream(stream) * pose[pose_index] * body_from_node.
// body_from_node includes the rest transforms from the driven ancestor down to this node. stream kNone: the
// node rests, and body_from_node is its world_from_node. The rest pose comes from the file or from animations
// (PoseState::set_rest).
struct NodeDrive {
  uint32_t stream = kNone;
  uint32_t pose_index = 0;
  wire::Affine3x4 body_from_node;
};

struct Stream {
  bool active = false;
  std::string name;
  uint64_t epoch = 0;
  wire::Affine3x4d world_from_stream;
  std::vector<wire::Affine3x4> poses;  // the shown frame: stream_from_body
  wire::PoseFrameHeader header;        // of the shown frame; sequence 0 = none yet
  uint64_t revision = 0;               // incremented when poses change; monotonic even if the slot is reused
  // Indices into the description's names; see PoseState::names_at().
  IndexSet unmatched_names;               // no scene node has this name
  IndexSet conflicting_names;             // an older stream drives the node
  IndexSet contested_names;               // this stream drives the node, and another one requests it
  Condition condition = Condition::live;  // as of the last advance(); not live: the shown frame is stale
  bool interpolated = false;
  uint64_t frames_received = 0;    // whole frames that were shown
  uint64_t frames_incomplete = 0;  // superseded before all their parts arrived
  uint64_t frames_stale = 0;       // wrong epoch, duplicates, or not newer than the shown frame
  // Wrong node count, contradicting parts, or over the peer's budget.
  uint64_t frames_refused = 0;
  uint64_t frames_without_base = 0;          // partial frames before the first whole one
  uint64_t frames_queued = 0;                // whole frames queued for scene edits
  uint64_t frames_superseded = 0;            // queued frames that newer ones replaced
  uint64_t edits_received = 0;               // accepted scene edits
  uint64_t edits_stale = 0;                  // wrong epoch, or not newer than the received ones
  uint64_t edits_refused = 0;                // over the limits of a stream
  std::vector<uint32_t> scene_node_of_pose;  // kNone: unmatched or conflicting
};

// Scene changes of one stream since the last take_scene_changes().
struct SceneChanges {
  StreamId stream = kNone;
  uint64_t epoch = 0;
  uint64_t age = 0;                    // smaller is older; the older stream wins a node that two edit
  bool ended = false;                  // the stream is gone: its changes are undone
  std::vector<wire::SceneEdit> edits;  // sorted by version; the newest of each key
  // Budget of the publishing peer; null: no limits.
  std::shared_ptr<PeerBudget> budget = nullptr;
  std::vector<BudgetCharge> charges = {};  // one per edit; held while its value is in force
  // With `ended`: the stream may reconnect. Nodes that it edited stay reserved until another change with
  // `ended` arrives for this age.
  bool may_return = false;
};

// A refusal of frames or edits by the peer's budget.
struct BudgetRefusal {
  StreamId stream = kNone;
  Resource resource = Resource::pose_bytes;
  std::string message;  // text of the budget's error
};

class PoseState {
 public:
  explicit PoseState(const scene::Scene& scene);
  // Replaces the scene, usually by the file's scene with more nodes appended. Streams keep their frames and
  // their nodes (same index and path, else the first node of the path). The old scene must be alive during
  // the call.
  void set_scene(const scene::Scene& scene);

  // Adds a stream and binds its names: by unique exact node name first, then by path. A node that another
  // active stream drives stays with that stream; the name is reported as conflicting.
  // budget: charged for the stream's memory; null: no limits.
  // place: reservation from suspend_stream(); the stream inherits its age and nodes if it still exists.
  StreamId add_stream(const wire::StreamDescription& description,
                      std::shared_ptr<PeerBudget> budget = nullptr, uint64_t place = 0);
  // Removes a stream. Its nodes rest, or pass to the next stream that claims them.
  void remove_stream(StreamId id);
  // Removes a stream, but reserves its age and nodes until advance(until_ns). The youngest reservation
  // expires if there are more than kMaxPlaces. Returns the reservation.
  uint64_t suspend_stream(StreamId id, int64_t until_ns);
  static constexpr size_t kMaxPlaces = 64;
  // Nodes of the place that this stream waits for pass to it; nodes that the place's stream edited are free.
  // When that stream returns it waits for them first.
  void lend_place(uint64_t place, StreamId id);

  // Returns the names at these indices, as many as fit into max_bytes (each costs 8 bytes more).
  std::vector<std::string> names_at(StreamId id, const IndexSet& indices, size_t max_bytes) const;
  // Number of names looked up, bound or moved to another stream so far.
  uint64_t name_lookups() const { return names_touched_; }

  // Receives a whole frame or a part. Parts of one sequence are assembled; a frame is shown when it is whole.
  // Frames of a wrong epoch or node count, or not newer than the shown one, are dropped and counted. Returns
  // true if the shown frame changed.
  bool push(StreamId id, const wire::PoseFrameView& frame);

  // Applies a scene edit. Returns true if a queued frame became shown.
  bool apply(StreamId id, wire::SceneEdit&& edit);
  bool apply(StreamId id, const wire::UnknownEdit& edit);
  // Returns and clears the changes since the last call: ended streams first, then by age, oldest first.
  std::vector<SceneChanges> take_scene_changes();
  // Returns and clears the refusals since the last call, at most one per stream and resource.
  std::vector<BudgetRefusal> take_refusals() { return std::exchange(refusals_, {}); }
  // From now on assets and replaced vertices load on another thread: frames wait for finish_edit() of their
  // version. finish_edit() is also called for failed edits; it returns true if the shown frame changed.
  void load_assets_asynchronously() { load_assets_asynchronously_ = true; }
  bool finish_edit(StreamId id, uint64_t epoch, uint64_t version);

  // Sets the rest pose of nodes without a driver. It has as many nodes as the scene.
  void set_rest(const RestPose& rest);
  // Layout of Scene::morph_weights.
  const std::vector<float>& morph_weights() const { return rest_.morph_weights; }

  // Enables the playout buffer of a stream: frames are delayed and interpolated. nullopt: the delay follows
  // the jitter. May be called again with another delay.
  void interpolate(StreamId id, std::optional<int64_t> fixed_delay_ns);
  // Disables the playout buffer: the newest frame is shown immediately.
  void show_newest(StreamId id, int64_t now_ns);
  // Playout delay; 0 without a playout buffer.
  int64_t delay_ns(StreamId id) const;
  // See Liveness::gaps_ms().
  std::vector<float> gaps_ms(StreamId id) const { return receive_states_[id].liveness.gaps_ms(); }
  // push() with the local monotonic times at which the frame was published (estimated) and received.
  bool push(StreamId id, const wire::PoseFrameView& frame, int64_t published_ns, int64_t received_ns);
  // Shows the frames that are due. Returns true if the shown poses changed.
  bool advance(int64_t now_ns);

  // Shows an externally interpolated frame, independent of the one shown before. For recordings, where time
  // does not advance as on a link.
  void show_moment(StreamId id, const wire::PoseFrameHeader& header, std::span<const wire::Affine3x4> poses);

  const std::vector<Stream>& streams() const { return streams_; }
  // Of the peer that publishes an active stream; null: without limits.
  const std::shared_ptr<PeerBudget>& budget(StreamId id) const { return receive_states_[id].budget; }
  const NodeNames& names() const { return names_; }
  // Incremented by set_scene(). new_node_of_old() maps nodes of the previous scene to the current one; kNone:
  // the node is gone.
  uint64_t scene_revision() const { return scene_revision_; }
  const std::vector<uint32_t>& new_node_of_old() const { return new_node_of_old_; }
  // Age of the stream that drives this node (smaller is older); nullopt: no driver.
  std::optional<uint64_t> age_of_driver(uint32_t node) const;
  uint64_t oldest_age() const;  // of streams and places; UINT64_MAX: there are none
  uint64_t binding_revision() const { return binding_revision_; }  // rises when that may have changed
  // Rises with each node that another stream moves from then on. driver_changes_since() has these nodes, some
  // of them more than once; nothing: it is not known any more, or the scene was replaced.
  uint64_t driver_revision() const { return driver_changes_begin_ + driver_changes_.size(); }
  std::optional<std::span<const uint32_t>> driver_changes_since(uint64_t revision) const;
  // One per scene node. drive_revision() changes when bindings or rest poses do.
  const std::vector<NodeDrive>& node_drives() const;
  uint64_t drive_revision() const { return drive_revision_; }
  // Incremented by every change of the shown poses.
  uint64_t revision() const;

  // World transform of one node as shown, computed on the CPU. For cameras and panels, not for rendering.
  glm::mat4 world_from_node(uint32_t node) const;

  // Tags of all active streams with a shown frame.
  std::vector<FrameTag> shown() const;

  // Simulator time of the shown frame of the youngest stream that shows one; nullopt: none does.
  std::optional<int64_t> sim_time_ns() const;

 private:
  // Receive state of one stream, beside its public part (Stream).
  struct ReceiveState {
    std::shared_ptr<PeerBudget> budget;
    uint64_t order = 0;     // smaller is older; the older stream keeps a node
    bool is_place = false;  // reservation of a suspended stream; drives its nodes with pose kNone
    std::vector<uint32_t> node_of_pose;  // kNone: unmatched; of a reservation: its nodes
    std::vector<std::string> names;
    std::vector<std::pair<uint64_t, uint32_t>> poses_by_hash;  // of names; built on demand
    std::vector<wire::Affine3x4> body_from_node;               // empty, one for all, or one per pose
    stream::FrameAssembler assembler;
    std::optional<Playout> playout;  // interpolated streams
    Liveness liveness;
    StreamEdits edits;
    FrameQueue held;
    uint64_t newest_sequence = 0;               // newest received frame: shown, buffered or queued
    bool newest_is_partial = false;             // a whole frame of the same sequence may complete it
    std::vector<wire::Affine3x4> newest_poses;  // interpolated streams: base of partial frames
    std::vector<wire::Affine3x4> merged;        // scratch memory of partial frames
    stream::PoseMemory memory;                  // charges for the shown poses, newest_poses and merged
    uint32_t refusals = 0;                      // bit mask of resources whose refusal was reported
  };
  // A name whose node another stream drives. The oldest claim gets the node next.
  struct Claim {
    uint32_t node = kNone;
    uint64_t order = 0;
    uint32_t pose = 0;
    StreamId stream = kNone;
    auto operator<=>(const Claim&) const = default;
  };
  // Reservation of a suspended stream.
  struct Place {
    uint64_t order = 0;
    int64_t until_ns = 0;
    StreamId slot = kNone;  // holds the nodes; kNone: returned, and only its edits are reserved
    bool has_edits = false;
    uint64_t epoch = 0;
  };
  StreamId free_slot();
  bool take_place(uint64_t order, StreamId& slot);
  void end_place(const Place& place);
  void reserve_place(Place place);
  void bind(StreamId id, uint32_t pose, uint32_t node);
  void drive(StreamId id, uint32_t pose, uint32_t node);
  void pass_on(uint32_t node);
  void drop_claim(StreamId id, uint32_t pose, uint32_t node);
  void drop_claims(StreamId id);
  struct ChangedName {
    uint64_t hash = 0;
    std::string_view name;
  };
  std::vector<ChangedName> find_changed_names(const scene::Scene& before) const;
  void bind_unmatched(StreamId id, const std::vector<ChangedName>& changed);
  bool is_contested(uint32_t node, StreamId driver) const;
  void note_driver_change(uint32_t node);
  void forget_driver_changes();
  void clear_slot(StreamId id);
  void bindings_changed();
  void refuse(StreamId id, Resource resource, const std::string& message);
  bool refuse_frame(StreamId id);
  void derive_drives() const;
  bool take(StreamId id, const wire::PoseFrameHeader& header, std::span<const wire::Affine3x4> poses,
            int64_t published_ns, int64_t received_ns);
  bool take_partial(StreamId id, const wire::PoseFrameView& frame, int64_t published_ns, int64_t received_ns);
  bool accept(StreamId id, const wire::PoseFrameHeader& header, std::span<const wire::Affine3x4> poses,
              int64_t published_ns, int64_t received_ns);
  bool repair(StreamId id, const wire::PoseFrameHeader& header, std::span<const wire::Affine3x4> poses);
  bool release_held(StreamId id);
  bool count_edit(StreamId id, StreamEdits::Outcome outcome);
  void show(StreamId id, const wire::PoseFrameHeader& header, std::span<const wire::Affine3x4> poses);

  const scene::Scene* scene_;
  const uint32_t file_nodes_;  // leading nodes that all scenes share
  RestPose rest_;
  NodeNames names_;
  uint64_t scene_revision_ = 0;
  std::vector<uint32_t> new_node_of_old_;
  std::vector<Stream> streams_;
  std::vector<ReceiveState> receive_states_;  // parallel to streams_
  std::vector<SceneChanges> ended_;
  bool load_assets_asynchronously_ = false;
  uint64_t next_rank_ = 1;
  std::vector<Place> places_;
  std::vector<BudgetRefusal> refusals_;
  mutable std::vector<NodeDrive> node_drives_;  // derived on access
  mutable bool drives_changed_ = true;
  std::vector<uint32_t> driver_stream_of_node_, driver_pose_of_node_;
  uint64_t driver_changes_begin_ = 0;  // revision of the first of:
  std::vector<uint32_t> driver_changes_;
  std::set<Claim> claims_;
  uint64_t names_touched_ = 0;
  uint64_t drive_revision_ = 0, binding_revision_ = 0;
};

}  // namespace fire3dv::state
