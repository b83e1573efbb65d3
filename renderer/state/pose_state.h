// What to show: the newest whole frame of each stream, bound to scene nodes. Knows neither sockets nor
// Vulkan, so the same object serves live links, the in-process link and recordings. One thread.
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

#include "protocol/base/peer_budget.h"
#include "protocol/error.h"
#include "protocol/wire/messages.h"
#include "renderer/scene/scene.h"
#include "renderer/state/animation.h"
#include "renderer/state/bindings.h"
#include "renderer/state/frame_assembly.h"
#include "renderer/state/held_frames.h"
#include "renderer/state/index_set.h"
#include "renderer/state/liveness.h"
#include "renderer/state/playout.h"
#include "renderer/state/stream_edits.h"

namespace fire3dv::state {

using StreamId =
    uint32_t;  // index of PoseState::streams(), stable until the stream is removed, then given out again
constexpr uint32_t kNone = UINT32_MAX;

// Age of a stream: smaller is older. Runs of one stream that returned to its place have ages of their own and
// the same rank; between streams only ranks are compared.
constexpr uint64_t age_rank(uint64_t age) {
  return age >> 24;
}

// Which pose frame an image shows; travels with the image to its sink.
struct FrameTag {
  std::string stream;  // the adapter's name
  uint64_t epoch = 0;
  uint64_t sequence = 0;
  int64_t sim_time_ns = 0;
  uint64_t publish_time_ns = 0;  // publisher's monotonic clock
  Condition condition = Condition::live;
};

// How a scene node moves: world_from_node = world_from_stream(stream) * pose[pose_index] * body_from_node,
// where body_from_node already holds the rest transform from the driven ancestor down to this node. stream ==
// kNone: the node rests, and body_from_node is its world_from_node at rest. Rest is what the scene's file
// says, or what an animation makes of it (PoseState::set_rest).
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
  uint64_t revision = 0;  // +1 whenever poses change; never goes back, even for another stream here
  // Indices of the description's names; PoseState::names_at() has the names.
  IndexSet unmatched_names;               // no scene node has the name
  IndexSet conflicting_names;             // an older stream drives the node
  IndexSet contested_names;               // this stream drives the node, and another stream asks for it too
  Condition condition = Condition::live;  // as of the last advance(); a picture that is held is not alive
  bool interpolated = false;
  uint64_t frames_received = 0;    // whole frames that were shown
  uint64_t frames_incomplete = 0;  // frames that a newer one overtook before all their parts had come
  uint64_t frames_stale = 0;       // pushes of another epoch, not newer than the shown frame, or repeated
  uint64_t frames_refused = 0;     // pushes with a wrong node count, that contradict their other parts, or
                                   // have no room in the peer's budget
  uint64_t frames_baseless = 0;    // partial frames before any whole one
  uint64_t frames_held = 0;        // whole frames that had to wait for scene edits
  uint64_t frames_overtaken = 0;   // of those: given up for newer ones
  uint64_t edits_received = 0;     // scene edits that were taken on
  uint64_t edits_stale = 0;        // of another epoch, or not newer than what had come
  uint64_t edits_refused = 0;      // more than a stream may make us keep
  std::vector<uint32_t> scene_node_of_pose;  // kNone = unmatched or conflicting
};

// What one stream changed about the scene since the last look.
struct SceneChanges {
  StreamId stream = kNone;
  uint64_t epoch = 0;
  uint64_t age = 0;                    // smaller: an older stream, which keeps a node that two edit
  bool ended = false;                  // the stream is gone: whatever it changed is undone
  std::vector<wire::SceneEdit> edits;  // by version; of each key the newest
  std::shared_ptr<PeerBudget> budget =
      nullptr;                             // of the peer that publishes the stream; null: without limits
  std::vector<BudgetCharge> charges = {};  // of each edit, held for as long as its value is in force
  // With `ended`: the stream may return. Nodes that it edited stay reserved until another change with `ended`
  // comes for this age.
  bool may_return = false;
};

// Frames or edits of a stream that its peer's budget has no room for.
struct BudgetRefusal {
  StreamId stream = kNone;
  Resource resource = Resource::pose_bytes;
  std::string message;  // the budget's sentence
};

class PoseState {
 public:
  explicit PoseState(const scene::Scene& scene);
  // Another one is shown from now on, in general the file's scene with nodes added behind its own. Streams
  // keep their frames, and the nodes that they drive as long as these exist (same index and path, else the
  // first node of the path). The scene before must be alive during the call.
  void set_scene(const scene::Scene& scene);

  // Binds the stream's names: exact node name first (unique in the scene), then path. A node that another
  // active stream drives stays with it and is reported as conflicting.
  // budget: charged for what the stream makes the renderer hold; null: without limits.
  // place: of an earlier run that suspend_stream() returned; the stream gets its age and nodes, if it still
  // exists.
  StreamId add_stream(const wire::StreamDescription& description,
                      std::shared_ptr<PeerBudget> budget = nullptr, uint64_t place = 0);
  void remove_stream(StreamId id);  // its nodes rest again, and pass on to the next stream that asks for them
  // As remove_stream(), but its age and nodes stay reserved until advance() is called with that time, or more
  // than kMaxPlaces places of older streams are reserved. Returns the place.
  uint64_t suspend_stream(StreamId id, int64_t until_ns);
  static constexpr size_t kMaxPlaces = 64;

  // Names of a stream at these indices, the first that fit into so many bytes (each counts 8 more).
  std::vector<std::string> names_at(StreamId id, const IndexSet& indices, size_t max_bytes) const;
  // Names that were looked up, bound or moved to another stream so far.
  uint64_t names_touched() const { return names_touched_; }

  // Takes a whole frame or a part. Parts of one sequence are gathered; the frame is shown when it is whole.
  // Frames of another epoch, not newer than the shown one, or with a wrong node count are dropped and
  // counted. Returns true when the shown frame changed.
  bool push(StreamId id, const wire::PoseFrameView& frame);

  // A scene edit of this stream. Returns true when the shown frame changed: one had waited for it.
  bool apply(StreamId id, wire::SceneEdit&& edit);
  bool apply(StreamId id, const wire::UnknownEdit& edit);
  // What came since the last call, oldest stream first; streams that ended stand before all others.
  std::vector<SceneChanges> take_scene_changes();
  // Refusals since the last call, the first of each stream and resource.
  std::vector<BudgetRefusal> take_refusals() { return std::exchange(refusals_, {}); }
  // From now on nodes are added, and vertices replaced, beside the frames: frames wait until finish_edit()
  // says that the edit of this version is in effect, or never will be. Returns true when the shown frame
  // changed.
  void load_assets_aside() { load_assets_aside_ = true; }
  bool finish_edit(StreamId id, uint64_t epoch, uint64_t version);

  // Where nodes are that no stream drives, and relative to what their descendants stand. As long as the
  // scene's own.
  void set_rest(const RestPose& rest);
  // As Scene::morph_weights.
  const std::vector<float>& morph_weights() const { return rest_.morph_weights; }

  // A stream whose frames come unevenly: from now on they are shown a little late, with what lies between
  // them. The delay follows the jitter unless it is given.
  // May be called again, with another delay.
  void interpolate(StreamId id, std::optional<int64_t> fixed_delay_ns);
  // The opposite: the newest frame at once, from now on.
  void show_newest(StreamId id, int64_t now_ns);
  // How late they are shown; 0 where they are not.
  int64_t delay_ns(StreamId id) const;
  // As Liveness::gaps_ms.
  std::vector<float> gaps_ms(StreamId id) const { return wishes_[id].liveness.gaps_ms(); }
  // As push, with the times, on this machine's monotonic clock, at which the frame was published (as far as
  // that is known) and came.
  bool push(StreamId id, const wire::PoseFrameView& frame, int64_t published_ns, int64_t received_ns);
  // Shows what is to be seen now. Returns true when that is something else than before.
  bool advance(int64_t now_ns);

  // A moment between any two frames, found elsewhere: shown as it is, whatever was shown before. For
  // recordings, where time does not pass as on a link.
  void show_moment(StreamId id, const wire::PoseFrameHeader& header, std::span<const wire::Affine3x4> poses);

  const std::vector<Stream>& streams() const { return streams_; }
  const NodeNames& names() const { return names_; }
  // Rises with set_scene(); new_node_of_old() has the nodes of the scene before in the one that is shown,
  // kNone where they are gone.
  uint64_t scene_revision() const { return scene_revision_; }
  const std::vector<uint32_t>& new_node_of_old() const { return new_node_of_old_; }
  // Of the stream that moves this node: smaller is older. Nothing: none does.
  std::optional<uint64_t> age_of_driver(uint32_t node) const;
  uint64_t oldest_age() const;  // of streams and places; UINT64_MAX: there are none
  uint64_t binding_revision() const { return binding_revision_; }  // rises when that may have changed
  // One per scene node. drive_revision() changes when bindings or rest poses do.
  const std::vector<NodeDrive>& node_drives() const;
  uint64_t drive_revision() const { return drive_revision_; }
  // Rises with whatever changes what is shown.
  uint64_t revision() const;

  // Global transform of one node as shown now, on the CPU: for cameras and panels, not for drawing.
  glm::mat4 world_from_node(uint32_t node) const;

  // The tags of all active streams that have shown a frame.
  std::vector<FrameTag> shown() const;

  // Of the frame shown of the stream that came last, if any has shown one.
  std::optional<int64_t> sim_time_ns() const;

 private:
  // What a stream asked for, beside what it got (Stream).
  struct Wish {
    std::shared_ptr<PeerBudget> budget;
    uint64_t order = 0;                  // smaller = older: the older stream keeps a node
    bool is_place = false;               // of a stream that may return; drives its nodes with pose kNone
    std::vector<uint32_t> node_of_pose;  // kNone = unmatched; of a place: its nodes
    std::vector<std::string> names;
    std::vector<std::pair<uint64_t, uint32_t>> poses_by_hash;  // of names; made when a scene change needs it
    std::vector<wire::Affine3x4> body_from_node;               // none, one for all, or one per pose
    FrameAssembly assembly;
    std::optional<Playout> playout;  // interpolated streams
    Liveness liveness;
    StreamEdits edits;
    HeldFrames held;
    uint64_t newest_sequence = 0;               // of what was taken: shown, to be shown, or held
    bool newest_is_partial = false;             // a whole frame of the same sequence may repair it
    std::vector<wire::Affine3x4> newest_poses;  // interpolated streams: what a partial frame stands on
    std::vector<wire::Affine3x4> merged;        // memory for partial frames
    PoseMemory memory;                          // of the shown poses, newest_poses and merged
    uint32_t refusals = 0;                      // bits of the resources that were reported
  };
  // A name that waits for a node that another stream drives. The oldest gets it next.
  struct Claim {
    uint32_t node = kNone;
    uint64_t order = 0;
    uint32_t pose = 0;
    StreamId stream = kNone;
    auto operator<=>(const Claim&) const = default;
  };
  // What a stream that ended left reserved.
  struct Place {
    uint64_t order = 0;
    int64_t until_ns = 0;
    StreamId slot = kNone;  // that holds its nodes; kNone: it has returned, and only its edits are reserved
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
  const uint32_t file_nodes_;  // the first nodes of all scenes
  RestPose rest_;
  NodeNames names_;
  uint64_t scene_revision_ = 0;
  std::vector<uint32_t> new_node_of_old_;
  std::vector<Stream> streams_;
  std::vector<Wish> wishes_;  // beside streams_
  std::vector<SceneChanges> ended_;
  bool load_assets_aside_ = false;
  uint64_t next_rank_ = 1;
  std::vector<Place> places_;
  std::vector<BudgetRefusal> refusals_;
  mutable std::vector<NodeDrive> node_drives_;  // derived when they are read
  mutable bool drives_changed_ = true;
  std::vector<uint32_t> driver_stream_of_node_, driver_pose_of_node_;
  std::set<Claim> claims_;
  uint64_t names_touched_ = 0;
  uint64_t drive_revision_ = 0, binding_revision_ = 0;
};

}  // namespace fire3dv::state
