#include "renderer/state/pose_state.h"

#include <algorithm>

#include "renderer/scene/model/math.h"

namespace fire3dv::state {

PoseState::PoseState(const scene::Scene& scene)
    : scene_(&scene),
      file_nodes_(static_cast<uint32_t>(scene.nodes.size())),
      rest_(rest_pose(scene)),
      names_(scene, file_nodes_),
      node_drives_(scene.nodes.size()),
      driver_stream_of_node_(scene.nodes.size(), kNone),
      driver_pose_of_node_(scene.nodes.size(), kNone) {}

// A node follows its nearest driven ancestor or itself; rest transforms apply below. Parents precede
// children.
void PoseState::derive_drives() const {
  for (uint32_t node = 0; node < scene_->nodes.size(); ++node) {
    NodeDrive& drive = node_drives_[node];
    drive = NodeDrive{};
    const uint32_t stream = driver_stream_of_node_[node];
    if (stream != kNone && streams_[stream].header.sequence != 0) {
      const auto& offsets = receive_states_[stream].body_from_node;
      drive.stream = stream;
      drive.pose_index = driver_pose_of_node_[node];
      if (!offsets.empty()) drive.body_from_node = offsets[offsets.size() == 1 ? 0 : drive.pose_index];
      continue;
    }
    const uint32_t parent = scene_->nodes[node].parent;
    if (parent == scene::kNone || node_drives_[parent].stream == kNone) {
      drive.body_from_node = scene::to_affine(rest_.world_from_node[node]);
      continue;
    }
    drive = node_drives_[parent];
    drive.body_from_node =
        scene::to_affine(scene::to_mat4(drive.body_from_node) * rest_.parent_from_node[node]);
  }
  drives_changed_ = false;
}

const std::vector<NodeDrive>& PoseState::node_drives() const {
  if (drives_changed_) derive_drives();
  return node_drives_;
}

void PoseState::set_rest(const RestPose& rest) {
  FIRE3DV_ASSERT(rest.parent_from_node.size() == scene_->nodes.size() &&
                 rest.world_from_node.size() == scene_->nodes.size() &&
                 rest.morph_weights.size() == scene_->morph_weights.size());
  rest_ = rest;
  drives_changed_ = true;
  ++drive_revision_;
}

void PoseState::interpolate(StreamId id, std::optional<int64_t> fixed_delay_ns) {
  if (id >= streams_.size() || !streams_[id].active) return;
  ReceiveState& wish = receive_states_[id];
  // Base of later partial frames.
  const std::vector<wire::Affine3x4>& poses = streams_[id].poses;
  if (!wish.playout && wish.newest_sequence != 0 && wish.memory.reserve(wish.newest_poses, poses.size()))
    wish.newest_poses.assign(poses.begin(), poses.end());
  streams_[id].interpolated = true;
  wish.playout.emplace(fixed_delay_ns, wish.budget);
}

void PoseState::show_newest(StreamId id, int64_t now_ns) {
  if (id >= streams_.size() || !receive_states_[id].playout) return;
  constexpr int64_t kLongAfterAllNs = 60'000'000'000;
  if (const auto last = receive_states_[id].playout->at(now_ns + kLongAfterAllNs); last && last->changed)
    show(id, last->header, last->poses);
  receive_states_[id].playout.reset();
  streams_[id].interpolated = false;
}

int64_t PoseState::delay_ns(StreamId id) const {
  return receive_states_[id].playout ? receive_states_[id].playout->delay_ns() : 0;
}

bool PoseState::push(StreamId id, const wire::PoseFrameView& frame) {
  return push(id, frame, 0, 0);
}

bool PoseState::push(StreamId id, const wire::PoseFrameView& frame, int64_t published_ns,
                     int64_t received_ns) {
  if (id >= streams_.size() || !streams_[id].active) return false;
  Stream& stream = streams_[id];
  ReceiveState& wish = receive_states_[id];
  // A whole frame is not stale if its sequence was only received in part: it completes that frame.
  const bool may_repair =
      frame.header.sequence == wish.newest_sequence && wish.newest_is_partial && frame.node_indices.empty();
  if (frame.header.epoch != stream.epoch ||
      (frame.header.sequence <= stream.header.sequence && !may_repair)) {
    ++stream.frames_stale;
    return false;
  }
  if (frame.node_count != stream.scene_node_of_pose.size()) {
    ++stream.frames_refused;
    return false;
  }
  if (!frame.node_indices.empty()) return take_partial(id, frame, published_ns, received_ns);
  if (frame.first_node == 0 && frame.poses.size() == frame.node_count) {
    return take(id, frame.header, frame.poses, published_ns, received_ns);
  }
  using Outcome = stream::FrameAssembler::Outcome;
  const Outcome outcome = wish.assembler.add(frame);
  stream.frames_incomplete += wish.assembler.take_given_up();
  switch (outcome) {
    case Outcome::whole:
      return take(id, wish.assembler.header(), wish.assembler.poses(), published_ns, received_ns);
    case Outcome::open:
      break;
    case Outcome::stale:
      ++stream.frames_stale;
      break;
    case Outcome::refused:
      ++stream.frames_refused;
      break;
    case Outcome::over_budget:
      return refuse_frame(id);
  }
  return false;
}

// Drops a frame that exceeds the peer's budget, and reports it.
bool PoseState::refuse_frame(StreamId id) {
  ++streams_[id].frames_refused;
  const ReceiveState& wish = receive_states_[id];
  if (!wish.budget) return false;
  const uint64_t used = wish.budget->used(Resource::pose_bytes);
  refuse(id, Resource::pose_bytes,
         "pose frames use " + amount_text(Resource::pose_bytes, used) + " of " +
             amount_text(Resource::pose_bytes, wish.budget->limit(Resource::pose_bytes)) +
             " of this peer, and the next frame has no room there or in what all peers share (the renderer's "
             "options --peer-limit pose-bytes=VALUE and shared-pose-bytes=VALUE change it)");
  return false;
}

void PoseState::refuse(StreamId id, Resource resource, const std::string& message) {
  const uint32_t bit = 1u << static_cast<uint32_t>(resource);
  if ((std::exchange(receive_states_[id].refusals, receive_states_[id].refusals | bit) & bit) != 0) return;
  refusals_.push_back({id, resource, message});
}

// Merges a partial frame over the newest received frame, whether that is shown yet or not.
bool PoseState::take_partial(StreamId id, const wire::PoseFrameView& frame, int64_t published_ns,
                             int64_t received_ns) {
  Stream& stream = streams_[id];
  ReceiveState& wish = receive_states_[id];
  if (wish.newest_sequence == 0) {
    ++stream.frames_without_base;
    return false;
  }
  if (frame.header.sequence <= wish.newest_sequence) {
    ++stream.frames_stale;
    return false;
  }
  const std::vector<wire::Affine3x4>& base = !wish.held.empty() ? wish.held.newest().poses
                                             : wish.playout     ? wish.newest_poses
                                                                : stream.poses;
  if (base.size() != frame.node_count || !wish.memory.reserve(wish.merged, base.size()))
    return refuse_frame(id);
  wish.merged.assign(base.begin(), base.end());
  for (size_t i = 0; i < frame.poses.size(); ++i) wish.merged[frame.node_indices[i]] = frame.poses[i];
  const bool changed = take(id, frame.header, wish.merged, published_ns, received_ns);
  wish.newest_is_partial = true;
  return changed;
}

bool PoseState::take(StreamId id, const wire::PoseFrameHeader& header, std::span<const wire::Affine3x4> poses,
                     int64_t published_ns, int64_t received_ns) {
  Stream& stream = streams_[id];
  ReceiveState& wish = receive_states_[id];
  if (received_ns != 0) wish.liveness.on_frame(received_ns);
  if (header.sequence == wish.newest_sequence && wish.newest_is_partial) return repair(id, header, poses);
  if (header.scene_version <= wish.edits.applied())
    return accept(id, header, poses, published_ns, received_ns);
  if (header.sequence <= wish.newest_sequence) {  // frames older than a queued frame do not queue
    ++stream.frames_stale;
    return false;
  }
  const FrameQueue::Outcome held = wish.held.hold(header, poses, published_ns, received_ns);
  if (held == FrameQueue::Outcome::over_budget) return refuse_frame(id);
  wish.newest_sequence = header.sequence;
  wish.newest_is_partial = false;
  ++stream.frames_queued;
  if (held == FrameQueue::Outcome::replaced) ++stream.frames_superseded;
  wish.assembler.close(wish.newest_sequence);
  return false;
}

// Returns true if the frame is shown immediately.
bool PoseState::accept(StreamId id, const wire::PoseFrameHeader& header,
                       std::span<const wire::Affine3x4> poses, int64_t published_ns, int64_t received_ns) {
  Stream& stream = streams_[id];
  ReceiveState& wish = receive_states_[id];
  if (!wish.memory.reserve(wish.playout ? wish.newest_poses : stream.poses, poses.size()))
    return refuse_frame(id);
  stream.frames_superseded += wish.held.drop_up_to(header.sequence);
  if (header.sequence >= wish.newest_sequence) {
    if (header.sequence > wish.newest_sequence) wish.newest_is_partial = false;
    wish.newest_sequence = header.sequence;
    if (wish.playout) wish.newest_poses.assign(poses.begin(), poses.end());
  }
  if (!wish.playout) {
    show(id, header, poses);
    ++stream.frames_received;
    return true;
  }
  if (wish.playout->add(header, poses, published_ns, received_ns))
    ++stream.frames_received;
  else if (wish.playout->over_budget())
    return refuse_frame(id);
  else
    ++stream.frames_stale;
  return false;  // advance() shows it at its due time
}

// Completes the newest frame after a partial one of the same sequence.
bool PoseState::repair(StreamId id, const wire::PoseFrameHeader& header,
                       std::span<const wire::Affine3x4> poses) {
  Stream& stream = streams_[id];
  ReceiveState& wish = receive_states_[id];
  wish.newest_is_partial = false;
  bool changed = false;
  if (!wish.held.empty()) {  // the newest queued frame has this sequence
    const QueuedFrame& held = wish.held.newest();
    if (wish.held.hold(header, poses, held.published_ns, held.received_ns) ==
        FrameQueue::Outcome::over_budget)
      return refuse_frame(id);
  } else if (wish.playout) {
    wish.newest_poses.assign(poses.begin(), poses.end());
    wish.playout->replace(header.sequence, poses);
  } else if (!std::equal(poses.begin(), poses.end(), stream.poses.begin(), stream.poses.end())) {
    show(id, header, poses);
    changed = true;
  }
  wish.assembler.close(wish.newest_sequence);
  return changed;
}

bool PoseState::release_held(StreamId id) {
  ReceiveState& wish = receive_states_[id];
  bool changed = false;
  while (const QueuedFrame* frame = wish.held.release(wish.edits.applied()))
    changed |= accept(id, frame->header, frame->poses, frame->published_ns, frame->received_ns);
  return changed;
}

bool PoseState::advance(int64_t now_ns) {
  bool changed = false;
  std::erase_if(places_, [&](const Place& place) {
    if (place.until_ns > now_ns) return false;
    end_place(place);
    return true;
  });
  for (StreamId id = 0; id < streams_.size(); ++id) {
    ReceiveState& wish = receive_states_[id];
    if (!streams_[id].active) continue;
    streams_[id].condition = wish.liveness.at(now_ns);
    if (!wish.playout) continue;
    const auto shown = wish.playout->at(now_ns);
    if (!shown || !shown->changed) continue;
    show(id, shown->header, shown->poses);
    changed = true;
  }
  return changed;
}

void PoseState::show_moment(StreamId id, const wire::PoseFrameHeader& header,
                            std::span<const wire::Affine3x4> poses) {
  if (id >= streams_.size() || !streams_[id].active || header.sequence == 0 ||
      poses.size() != streams_[id].scene_node_of_pose.size())
    return;
  show(id, header, poses);
}

void PoseState::show(StreamId id, const wire::PoseFrameHeader& header,
                     std::span<const wire::Affine3x4> poses) {
  Stream& stream = streams_[id];
  if (!receive_states_[id].memory.reserve(stream.poses, poses.size())) return (void)refuse_frame(id);
  const bool first = stream.header.sequence == 0;
  stream.poses.assign(poses.begin(), poses.end());
  stream.header = header;
  ++stream.revision;
  stream.frames_incomplete += receive_states_[id].assembler.close_up_to(stream.header.sequence);
  if (!first) return;  // its nodes rested before the first frame
  drives_changed_ = true;
  ++drive_revision_;
}

uint64_t PoseState::revision() const {
  uint64_t revision = drive_revision_;
  for (const Stream& stream : streams_) revision += stream.revision;  // each term is monotonic
  return revision;
}

std::optional<uint64_t> PoseState::age_of_driver(uint32_t node) const {
  const uint32_t stream = driver_stream_of_node_[node];
  return stream == kNone ? std::nullopt : std::optional(receive_states_[stream].order);
}

glm::mat4 PoseState::world_from_node(uint32_t node) const {
  const NodeDrive& drive = node_drives()[node];
  if (drive.stream == kNone) return rest_.world_from_node[node];
  const Stream& stream = streams_[drive.stream];
  return glm::mat4(scene::to_dmat4(stream.world_from_stream) *
                   glm::dmat4(scene::to_mat4(stream.poses[drive.pose_index])) *
                   glm::dmat4(scene::to_mat4(drive.body_from_node)));
}

std::vector<FrameTag> PoseState::shown() const {
  std::vector<FrameTag> tags;
  for (const Stream& stream : streams_) {
    if (!stream.active || stream.header.sequence == 0) continue;
    tags.push_back({stream.name, stream.epoch, stream.header.sequence, stream.header.sim_time_ns,
                    stream.header.publish_time_ns, stream.condition});
  }
  return tags;
}

std::optional<int64_t> PoseState::sim_time_ns() const {
  std::optional<int64_t> time;
  uint64_t newest = 0;
  for (size_t id = 0; id < streams_.size(); ++id) {
    const Stream& stream = streams_[id];
    if (!stream.active || stream.header.sequence == 0 || receive_states_[id].order < newest) continue;
    newest = receive_states_[id].order;
    time = stream.header.sim_time_ns;
  }
  return time;
}

}  // namespace fire3dv::state
