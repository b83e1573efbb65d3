#include "renderer/state/pose_state.h"

#include <algorithm>

#include "renderer/scene/model/math.h"

namespace fire3dv::state {

PoseState::PoseState(const scene::Scene& scene)
    : bindings_(scene, [this](StreamId id) -> BoundNames& { return streams_[id]; }),
      rest_(rest_pose(scene)) {}

void PoseState::set_scene(const scene::Scene& scene, std::optional<uint32_t> file_nodes) {
  rest_ = rest_pose(scene);
  bindings_.set_scene(scene, file_nodes);
}

void PoseState::set_rest(const RestPose& rest) {
  FIRE3DV_ASSERT(rest.parent_from_node.size() == bindings_.scene().nodes.size() &&
                 rest.world_from_node.size() == bindings_.scene().nodes.size() &&
                 rest.morph_weights.size() == bindings_.scene().morph_weights.size());
  rest_ = rest;
  bindings_.rest_changed();
}

void PoseState::replace_stream(StreamId id, Stream&& stream) {
  const uint64_t revision = streams_[id].revision + 1;
  streams_[id] = std::move(stream);
  streams_[id].revision = revision;
}

StreamId PoseState::add_stream(const wire::StreamDescription& description, std::shared_ptr<PeerBudget> budget,
                               uint64_t reservation) {
  const NodeBindings::Slot slot = bindings_.take_slot(reservation);
  if (slot.id == streams_.size()) streams_.emplace_back();
  const size_t count = description.node_names.size();
  Stream stream(FrameReceiver(description.epoch, count, std::move(budget)));
  if (load_assets_asynchronously_) stream.load_assets_asynchronously();
  stream.active = true;
  stream.name = description.adapter_name;
  stream.world_from_stream = description.world_from_stream;
  stream.unmatched_names = stream.conflicting_names = stream.contested_names = IndexSet(count);
  stream.scene_node_of_pose.assign(count, kNone);
  replace_stream(slot.id, std::move(stream));
  bindings_.add(slot, reservation, description);
  return slot.id;
}

wire::StreamDescription PoseState::description(StreamId id) const {
  wire::StreamDescription description;
  description.epoch = streams_[id].epoch;
  description.adapter_name = streams_[id].name;
  description.world_from_stream = streams_[id].world_from_stream;
  description.node_names = bindings_.names(id);
  description.body_from_node = bindings_.body_from_node(id);
  return description;
}

// Epoch of the stream if its edits were applied to the scene.
std::optional<uint64_t> PoseState::edited_epoch(StreamId id) const {
  return streams_[id].has_applied_edits() ? std::optional(streams_[id].epoch) : std::nullopt;
}

void PoseState::remove_stream(StreamId id) {
  if (!is_active(id)) return;
  bindings_.remove(id, edited_epoch(id));
  replace_stream(id, {});
}

uint64_t PoseState::suspend_stream(StreamId id, int64_t until_ns) {
  if (!is_active(id)) return 0;
  const uint64_t reservation = bindings_.suspend(id, until_ns, edited_epoch(id));
  replace_stream(id, {});
  return reservation;
}

void PoseState::pass_reserved_nodes(uint64_t reservation, StreamId id) {
  if (is_active(id)) bindings_.pass_reserved_nodes(reservation, id);
}

// Runs an action on an active stream's receiver. The stream drives its nodes from its first shown frame on.
template <typename Action>
bool PoseState::update(StreamId id, Action&& action) {
  if (!is_active(id)) return false;
  const bool was_shown = streams_[id].header.sequence != 0;
  const bool changed = action(streams_[id]);
  if (!was_shown && streams_[id].header.sequence != 0) bindings_.begin_driving(id);
  return changed;
}

bool PoseState::push(StreamId id, const wire::PoseFrameView& frame, int64_t published_ns,
                     int64_t received_ns) {
  return update(id, [&](FrameReceiver& stream) { return stream.push(frame, published_ns, received_ns); });
}

bool PoseState::apply(StreamId id, wire::SceneEdit&& edit) {
  return update(id, [&](FrameReceiver& stream) { return stream.apply(std::move(edit)); });
}

bool PoseState::apply(StreamId id, const wire::UnknownEdit& edit) {
  return update(id, [&](FrameReceiver& stream) { return stream.apply(edit); });
}

bool PoseState::finish_edit(StreamId id, uint64_t epoch, uint64_t version) {
  return update(id,
                [&](FrameReceiver& stream) { return stream.epoch == epoch && stream.finish_edit(version); });
}

void PoseState::interpolate(StreamId id, std::optional<int64_t> fixed_delay_ns) {
  if (is_active(id)) streams_[id].interpolate(fixed_delay_ns);
}

void PoseState::show_newest(StreamId id, int64_t now_ns) {
  update(id, [&](FrameReceiver& stream) {
    stream.show_newest(now_ns);
    return true;
  });
}

bool PoseState::advance(int64_t now_ns) {
  bindings_.expire(now_ns);
  bool changed = false;
  for (StreamId id = 0; id < streams_.size(); ++id)
    changed |= update(id, [&](FrameReceiver& stream) { return stream.advance(now_ns); });
  return changed;
}

void PoseState::show_moment(StreamId id, const wire::PoseFrameHeader& header,
                            std::span<const wire::Affine3x4> poses) {
  update(id, [&](FrameReceiver& stream) {
    if (header.sequence == 0 || poses.size() != stream.node_count()) return false;
    stream.show(header, poses);
    return true;
  });
}

std::vector<SceneChanges> PoseState::take_scene_changes() {
  std::vector<SceneChanges> changes;
  for (const NodeBindings::EndedEdits& ended : bindings_.take_ended_edits()) {
    changes.push_back({ended.stream, ended.epoch, ended.age, true, {}});
    changes.back().may_return = ended.may_return;
  }
  const auto first = static_cast<std::ptrdiff_t>(changes.size());
  for (StreamId id = 0; id < streams_.size(); ++id) {
    Stream& stream = streams_[id];
    if (!stream.active || !stream.has_new_edits()) continue;
    StreamEdits::Batch batch = stream.take_edits();
    changes.push_back({id, stream.epoch, bindings_.age(id), false, std::move(batch.edits), stream.budget(),
                       std::move(batch.charges)});
  }
  std::sort(changes.begin() + first, changes.end(),
            [](const SceneChanges& a, const SceneChanges& b) { return a.age < b.age; });
  return changes;
}

std::vector<BudgetRefusal> PoseState::take_refusals() {
  std::vector<BudgetRefusal> refusals;
  for (StreamId id = 0; id < streams_.size(); ++id) {
    for (FrameReceiver::Refusal& refusal : streams_[id].take_refusals())
      refusals.push_back({id, refusal.resource, std::move(refusal.message)});
  }
  return refusals;
}

uint64_t PoseState::revision() const {
  uint64_t revision = bindings_.drive_revision();
  for (const Stream& stream : streams_) revision += stream.revision;  // each term is monotonic
  return revision;
}

glm::mat4 PoseState::world_from_node(uint32_t node) const {
  const NodeDrive& drive = node_drives()[node];
  if (drive.stream == kNone) return rest_.world_from_node[node];
  const Stream& stream = streams_[drive.stream];
  return glm::mat4(scene::to_dmat4(stream.world_from_stream) *
                   glm::dmat4(scene::to_mat4(stream.poses[drive.pose_index])) *
                   glm::dmat4(scene::to_mat4(drive.body_from_node)));
}

namespace {

// Lengths of the axes of a transform.
glm::dvec3 scale_of(const glm::mat4& transform) {
  const glm::dmat4 m(transform);
  return {glm::length(glm::dvec3(m[0])), glm::length(glm::dvec3(m[1])), glm::length(glm::dvec3(m[2]))};
}

bool is_same_scale(const glm::dvec3& a, const glm::dvec3& b) {
  constexpr double kTolerance = 0.01;
  return glm::all(glm::lessThanEqual(glm::abs(a - b), kTolerance * glm::max(glm::abs(a), glm::abs(b))));
}

}  // namespace

template <typename Test>
IndexSet PoseState::driven_names(StreamId id, Test&& test) const {
  const Stream& stream = streams_[id];
  IndexSet names(stream.scene_node_of_pose.size());
  const std::vector<NodeDrive>& drives = node_drives();
  for (uint32_t pose = 0; pose < stream.scene_node_of_pose.size() && pose < stream.poses.size(); ++pose) {
    const uint32_t node = stream.scene_node_of_pose[pose];
    if (node != kNone && drives[node].stream == id && test(node, stream.poses[pose])) names.insert(pose);
  }
  return names;
}

IndexSet PoseState::names_without_scale(StreamId id) const {
  return driven_names(id, [this](uint32_t node, const wire::Affine3x4& pose) {
    const glm::dvec3 at_rest = scale_of(bindings_.scene().nodes[node].world_from_node);
    return !is_same_scale(at_rest, glm::dvec3(1)) &&
           is_same_scale(scale_of(scene::to_mat4(pose)), glm::dvec3(1)) &&
           !is_same_scale(scale_of(world_from_node(node)), at_rest);
  });
}

IndexSet PoseState::names_with_empty_pose(StreamId id) const {
  return driven_names(id, [](uint32_t, const wire::Affine3x4& pose) {
    return std::all_of(pose.m.begin(), pose.m.end(), [](float value) { return value == 0; });
  });
}

std::vector<std::string> PoseState::hidden_streams() const {
  std::vector<std::string> names;
  for (const Stream& stream : streams_) {
    if (stream.active && stream.budget() && stream.budget()->draw_cost().is_hidden)
      names.push_back(stream.name);
  }
  return names;
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
  for (StreamId id = 0; id < streams_.size(); ++id) {
    const Stream& stream = streams_[id];
    if (!stream.active || stream.header.sequence == 0 || bindings_.age(id) < newest) continue;
    newest = bindings_.age(id);
    time = stream.header.sim_time_ns;
  }
  return time;
}

}  // namespace fire3dv::state
