// Pose state: newest frame of each stream and the scene nodes that it drives. It owns a FrameReceiver for
// each stream and the NodeBindings of all. It has no sockets and no Vulkan, so that live links, in-process
// replay and recordings share it. One thread; times in nanoseconds on the local monotonic clock.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/peer_budget.h"
#include "protocol/wire/messages.h"
#include "renderer/scene/model/scene.h"
#include "renderer/state/frame_receiver.h"
#include "renderer/state/motion/animation.h"
#include "renderer/state/node_bindings.h"

namespace fire3dv::state {

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

// A stream: frames, bindings and description. Its revision is monotonic even if the slot is reused.
struct Stream : FrameReceiver, BoundNames {
  Stream() = default;
  explicit Stream(FrameReceiver&& receiver) : FrameReceiver(std::move(receiver)) {}

  bool active = false;
  std::string name;
  wire::Affine3x4d world_from_stream;
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
  PoseState(const PoseState&) = delete;
  PoseState& operator=(const PoseState&) = delete;
  // Replaces the scene, usually by the file's scene with more nodes appended. Streams keep their frames and
  // their nodes (same index and path, else the first node of the path). The old scene must be alive during
  // the call.
  // file_nodes: new number of the file's own nodes, when another version of the file is shown.
  void set_scene(const scene::Scene& scene, std::optional<uint32_t> file_nodes = std::nullopt);

  // Adds a stream and binds its names: by unique exact node name first, then by path. A node that another
  // active stream drives stays with that stream; the name is reported as conflicting.
  // budget: charged for the stream's memory; null: no limits.
  // reservation: reservation from suspend_stream(); the stream inherits its age and nodes if it still exists.
  StreamId add_stream(const wire::StreamDescription& description,
                      std::shared_ptr<PeerBudget> budget = nullptr, uint64_t reservation = 0);
  // Removes a stream. Its nodes rest, or pass to the next stream that claims them.
  void remove_stream(StreamId id);
  // Removes a stream, but reserves its age and nodes until advance(until_ns). The youngest reservation
  // expires if there are more than kMaxReservations. Returns the reservation.
  uint64_t suspend_stream(StreamId id, int64_t until_ns);
  static constexpr size_t kMaxReservations = NodeBindings::kMaxReservations;
  // Nodes of the reservation that this stream waits for pass to it; nodes that the reservation's stream
  // edited are free. When that stream returns it waits for them first.
  void pass_reserved_nodes(uint64_t reservation, StreamId id);

  // Returns the names at these indices, as many as fit into max_bytes (each costs 8 bytes more).
  std::vector<std::string> names_at(StreamId id, const IndexSet& indices, size_t max_bytes) const {
    return bindings_.names_at(id, indices, max_bytes);
  }
  // Names of the stream whose shown pose is rigid although the scene scales their node at rest: a pose
  // replaces the whole transform, so that the node has another size than in the file. For a stream with a
  // shown frame.
  IndexSet names_without_scale(StreamId id) const;
  // Names whose shown pose is twelve zeros, as in memory that has not been written: their nodes are
  // invisible.
  IndexSet names_with_empty_pose(StreamId id) const;
  // Epoch, names, world_from_stream and body_from_node of an active stream.
  wire::StreamDescription description(StreamId id) const;
  // Number of names looked up, bound or moved to another stream so far.
  uint64_t name_lookups() const { return bindings_.name_lookups(); }

  // Receives a whole frame or a part. Parts of one sequence are assembled; a frame is shown when it is whole.
  // Frames of a wrong epoch or node count, or not newer than the shown one, are dropped and counted. Returns
  // true if the shown frame changed. published_ns: publish time as estimated; received_ns: arrival time.
  bool push(StreamId id, const wire::PoseFrameView& frame, int64_t published_ns = 0, int64_t received_ns = 0);

  // Applies a scene edit. Returns true if a queued frame became shown.
  bool apply(StreamId id, wire::SceneEdit&& edit);
  bool apply(StreamId id, const wire::UnknownEdit& edit);
  // Returns and clears the changes since the last call: ended streams first, then by age, oldest first.
  std::vector<SceneChanges> take_scene_changes();
  // Returns and clears the refusals since the last call, at most one per stream and resource.
  std::vector<BudgetRefusal> take_refusals();
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
  int64_t delay_ns(StreamId id) const { return streams_[id].delay_ns(); }
  // See Liveness::gaps_ms().
  std::vector<float> gaps_ms(StreamId id) const { return streams_[id].gaps_ms(); }
  // Shows the frames that are due. Returns true if the shown poses changed.
  bool advance(int64_t now_ns);

  // Shows an externally interpolated frame, independent of the one shown before. For recordings, where time
  // does not advance as on a link.
  void show_moment(StreamId id, const wire::PoseFrameHeader& header, std::span<const wire::Affine3x4> poses);

  const std::vector<Stream>& streams() const { return streams_; }
  // Of the peer that publishes an active stream; null: without limits.
  const std::shared_ptr<PeerBudget>& budget(StreamId id) const { return streams_[id].budget(); }
  const NodeNames& names() const { return bindings_.node_names(); }
  // See NodeBindings.
  uint64_t scene_revision() const { return bindings_.scene_revision(); }
  const std::vector<uint32_t>& new_node_of_old() const { return bindings_.new_node_of_old(); }
  std::optional<uint64_t> age_of_driver(uint32_t node) const { return bindings_.age_of_driver(node); }
  uint64_t oldest_age() const { return bindings_.oldest_age(); }
  // Rises when drivers or ages may have changed.
  uint64_t binding_revision() const { return bindings_.revision(); }
  // Rises with each node that changes its driver. driver_changes_since() lists these nodes, some of them more
  // than once; nullopt: the list does not reach back that far, or the scene was replaced.
  uint64_t driver_revision() const { return bindings_.driver_revision(); }
  std::optional<std::span<const uint32_t>> driver_changes_since(uint64_t revision) const {
    return bindings_.driver_changes_since(revision);
  }
  // One per scene node. drive_revision() changes when bindings or rest poses do.
  const std::vector<NodeDrive>& node_drives() const { return bindings_.drives(rest_); }
  uint64_t drive_revision() const { return bindings_.drive_revision(); }
  // Incremented by every change of the shown poses.
  uint64_t revision() const;

  // World transform of one node as shown, computed on the CPU. For cameras and panels, not for rendering.
  glm::mat4 world_from_node(uint32_t node) const;

  // Tags of all active streams with a shown frame.
  std::vector<FrameTag> shown() const;

  // Names of the active streams whose content is hidden; see PeerBudget::DrawCost.
  std::vector<std::string> hidden_streams() const;

  // Simulator time of the shown frame of the youngest stream that shows one; nullopt: none does.
  std::optional<int64_t> sim_time_ns() const;

 private:
  // Names that drive a node and pass test(node, shown pose).
  template <typename Test>
  IndexSet driven_names(StreamId id, Test&& test) const;

  bool is_active(StreamId id) const { return id < streams_.size() && streams_[id].active; }
  template <typename Action>
  bool update(StreamId id, Action&& action);
  void replace_stream(StreamId id, Stream&& stream);
  std::optional<uint64_t> edited_epoch(StreamId id) const;

  std::vector<Stream> streams_;
  NodeBindings bindings_;
  RestPose rest_;
  bool load_assets_asynchronously_ = false;
};

}  // namespace fire3dv::state
