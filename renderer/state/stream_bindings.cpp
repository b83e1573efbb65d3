// Binding of streams to scene nodes within PoseState. It is incremental: adding or removing a stream costs
// its own names and the nodes that change drivers, independent of other streams.
#include <algorithm>

#include "protocol/base/keyed_hash.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::state {
namespace {

constexpr uint64_t kRunMask = (uint64_t{1} << 24) - 1;  // reconnection counter in an age; see age_rank()

}  // namespace

StreamId PoseState::free_slot() {
  for (StreamId id = 0; id < streams_.size(); ++id) {
    if (!streams_[id].active && !receive_states_[id].is_place) return id;
  }
  streams_.emplace_back();
  receive_states_.emplace_back();
  return static_cast<StreamId>(streams_.size() - 1);
}

// Returns true if the reservation exists; the caller then owns its slot.
bool PoseState::take_place(uint64_t order, StreamId& slot) {
  const auto place = std::find_if(places_.begin(), places_.end(), [&](const Place& each) {
    return each.order == order && each.slot != kNone;
  });
  if (place == places_.end() || (order & kRunMask) == kRunMask) return false;
  slot = std::exchange(place->slot, kNone);
  if (!place->has_edits) places_.erase(place);
  return true;
}

StreamId PoseState::add_stream(const wire::StreamDescription& description, std::shared_ptr<PeerBudget> budget,
                               uint64_t place) {
  StreamId id = kNone;
  const bool returns = place != 0 && take_place(place, id);
  if (!returns) id = free_slot();
  const std::vector<uint32_t> reserved =
      std::move(receive_states_[id].node_of_pose);  // nodes of the reservation

  Stream& stream = streams_[id];
  const uint64_t revision = stream.revision + 1;
  const size_t count = description.node_names.size();
  stream = Stream{};
  stream.revision = revision;
  stream.active = true;
  stream.name = description.adapter_name;
  stream.epoch = description.epoch;
  stream.world_from_stream = description.world_from_stream;
  stream.unmatched_names = stream.conflicting_names = stream.contested_names = IndexSet(count);
  stream.scene_node_of_pose.assign(count, kNone);

  ReceiveState& wish = receive_states_[id];
  wish = ReceiveState{};
  wish.order = returns ? place + 1 : next_rank_++ << 24;
  wish.assembler = stream::FrameAssembler(budget);
  wish.held = FrameQueue(budget);
  wish.edits = StreamEdits(budget);
  wish.memory = stream::PoseMemory(budget);
  wish.budget = std::move(budget);
  if (load_assets_asynchronously_) wish.edits.load_aside();
  wish.names = description.node_names;
  // A list of another length is meaningless (the decoder refuses it); the documented default is identity.
  const size_t offsets = description.body_from_node.size();
  if (offsets == 1 || offsets == count) wish.body_from_node = description.body_from_node;
  wish.node_of_pose.assign(count, kNone);
  for (uint32_t pose = 0; pose < count; ++pose) bind(id, pose, names_.find(wish.names[pose]));
  for (const uint32_t node : reserved) {  // reserved nodes that it does not claim any more
    if (driver_stream_of_node_[node] == id && driver_pose_of_node_[node] == kNone) pass_on(node);
  }
  bindings_changed();
  return id;
}

void PoseState::clear_slot(StreamId id) {
  const uint64_t revision = streams_[id].revision + 1;
  streams_[id] = Stream{};
  streams_[id].revision = revision;
  receive_states_[id] = ReceiveState{};
  bindings_changed();
}

void PoseState::remove_stream(StreamId id) {
  if (id >= streams_.size() || !streams_[id].active) return;
  if (receive_states_[id].edits.was_taken())
    ended_.push_back({id, streams_[id].epoch, receive_states_[id].order, true, {}});
  drop_claims(id);
  for (const uint32_t node : streams_[id].scene_node_of_pose) {
    if (node != kNone) pass_on(node);
  }
  clear_slot(id);
}

uint64_t PoseState::suspend_stream(StreamId id, int64_t until_ns) {
  if (id >= streams_.size() || !streams_[id].active) return 0;
  const Place place{receive_states_[id].order, until_ns, id, receive_states_[id].edits.was_taken(),
                    streams_[id].epoch};
  if (place.has_edits) {
    ended_.push_back({id, place.epoch, place.order, true, {}});
    ended_.back().may_return = true;
  }
  drop_claims(id);
  std::vector<uint32_t> nodes;
  for (const uint32_t node : streams_[id].scene_node_of_pose) {
    if (node == kNone) continue;
    driver_pose_of_node_[node] = kNone;
    nodes.push_back(node);
  }
  nodes.shrink_to_fit();
  clear_slot(id);
  receive_states_[id].order = place.order;
  receive_states_[id].is_place = true;
  receive_states_[id].node_of_pose = std::move(nodes);
  reserve_place(place);
  return place.order;
}

// Each rank has one reservation of nodes and one of edits. Beyond kMaxPlaces the youngest rank expires.
void PoseState::reserve_place(Place place) {
  if (place.has_edits) {
    std::erase_if(places_, [&](const Place& other) {
      if (age_rank(other.order) != age_rank(place.order)) return false;
      end_place(other);
      return true;
    });
  }
  places_.push_back(place);
  if (places_.size() <= kMaxPlaces) return;
  const auto youngest = std::max_element(places_.begin(), places_.end(),
                                         [](const Place& a, const Place& b) { return a.order < b.order; });
  const Place last = *youngest;
  places_.erase(youngest);
  end_place(last);
}

void PoseState::lend_place(uint64_t place, StreamId id) {
  const auto found = std::find_if(places_.begin(), places_.end(), [&](const Place& each) {
    return each.order == place && each.slot != kNone;
  });
  if (found == places_.end() || id >= streams_.size() || !streams_[id].active) return;
  if (std::exchange(found->has_edits, false))
    ended_.push_back({found->slot, found->epoch, found->order, true, {}});
  std::erase_if(receive_states_[found->slot].node_of_pose, [&](uint32_t node) {
    for (auto claim = claims_.lower_bound({node, 0, 0, 0}); claim != claims_.end() && claim->node == node;
         ++claim) {
      if (claim->stream != id) continue;
      const uint32_t pose = claim->pose;
      ++names_touched_;
      claims_.erase(claim);
      streams_[id].conflicting_names.erase(pose);
      drive(id, pose, node);
      return true;
    }
    return false;
  });
  bindings_changed();
}

void PoseState::end_place(const Place& place) {
  if (place.has_edits) ended_.push_back({place.slot, place.epoch, place.order, true, {}});
  if (place.slot == kNone) return;
  for (const uint32_t node : receive_states_[place.slot].node_of_pose) {
    if (driver_stream_of_node_[node] == place.slot) pass_on(node);
  }
  clear_slot(place.slot);
}

uint64_t PoseState::oldest_age() const {
  uint64_t oldest = UINT64_MAX;
  for (StreamId id = 0; id < streams_.size(); ++id) {
    if (streams_[id].active || receive_states_[id].is_place)
      oldest = std::min(oldest, receive_states_[id].order);
  }
  return oldest;
}

std::vector<std::string> PoseState::names_at(StreamId id, const IndexSet& indices, size_t max_bytes) const {
  std::vector<std::string> names;
  size_t bytes = 0;
  indices.visit([&](uint32_t index) {
    const std::string& name = receive_states_[id].names[index];
    bytes += name.size() + 8;
    if (bytes > max_bytes) return false;
    names.push_back(name);
    return true;
  });
  return names;
}

void PoseState::bind(StreamId id, uint32_t pose, uint32_t node) {
  ++names_touched_;
  receive_states_[id].node_of_pose[pose] = node;
  if (node == kNone) return streams_[id].unmatched_names.insert(pose);
  const StreamId driver = driver_stream_of_node_[node];
  const uint32_t driver_pose = driver_pose_of_node_[node];
  if (driver == kNone || (driver == id && driver_pose == kNone)) return drive(id, pose, node);
  claims_.insert({node, receive_states_[id].order, pose, id});
  streams_[id].conflicting_names.insert(pose);
  // The driver reports each contested node once, by its own name. Two names within one stream are no contest.
  if (driver != id && driver_pose != kNone) streams_[driver].contested_names.insert(driver_pose);
}

void PoseState::drive(StreamId id, uint32_t pose, uint32_t node) {
  note_driver_change(node);
  driver_stream_of_node_[node] = id;
  driver_pose_of_node_[node] = pose;
  streams_[id].scene_node_of_pose[pose] = node;
  if (is_contested(node, id)) streams_[id].contested_names.insert(pose);
}

bool PoseState::is_contested(uint32_t node, StreamId driver) const {
  for (auto claim = claims_.lower_bound({node, 0, 0, 0}); claim != claims_.end() && claim->node == node;
       ++claim) {
    if (claim->stream != driver) return true;
  }
  return false;
}

// The node's driver leaves it: the oldest claim is next.
void PoseState::pass_on(uint32_t node) {
  ++names_touched_;
  note_driver_change(node);
  driver_stream_of_node_[node] = driver_pose_of_node_[node] = kNone;
  const auto next = claims_.lower_bound({node, 0, 0, 0});
  if (next == claims_.end() || next->node != node) return;
  const Claim claim = *next;
  claims_.erase(next);
  streams_[claim.stream].conflicting_names.erase(claim.pose);
  drive(claim.stream, claim.pose, node);
}

// Whoever follows them more seldom than all nodes change looks at all nodes.
void PoseState::note_driver_change(uint32_t node) {
  constexpr size_t kMinKept = 1024;
  if (driver_changes_.size() >= std::max(kMinKept, driver_stream_of_node_.size())) forget_driver_changes();
  driver_changes_.push_back(node);
}

void PoseState::forget_driver_changes() {
  driver_changes_begin_ = driver_revision() + 1;
  driver_changes_.clear();
}

std::optional<std::span<const uint32_t>> PoseState::driver_changes_since(uint64_t revision) const {
  if (revision < driver_changes_begin_ || revision > driver_revision()) return std::nullopt;
  return std::span(driver_changes_).subspan(revision - driver_changes_begin_);
}

void PoseState::drop_claim(StreamId id, uint32_t pose, uint32_t node) {
  claims_.erase({node, receive_states_[id].order, pose, id});
  const StreamId driver = driver_stream_of_node_[node];
  const uint32_t driver_pose = driver_pose_of_node_[node];
  if (driver != kNone && driver != id && driver_pose != kNone && !is_contested(node, driver))
    streams_[driver].contested_names.erase(driver_pose);
}

void PoseState::drop_claims(StreamId id) {
  streams_[id].conflicting_names.visit([&](uint32_t pose) {
    ++names_touched_;
    drop_claim(id, pose, receive_states_[id].node_of_pose[pose]);
    return true;
  });
}

void PoseState::bindings_changed() {
  ++binding_revision_;
  ++drive_revision_;
  drives_changed_ = true;
}

// Returns names and paths of nodes that only one of both scenes has; all other look-ups are unchanged.
std::vector<PoseState::ChangedName> PoseState::find_changed_names(const scene::Scene& before) const {
  std::vector<ChangedName> changed;
  const auto add = [&changed](const scene::Node& node) {
    for (const std::string* name : {&node.name, &node.path}) changed.push_back({keyed_hash(*name), *name});
  };
  std::vector<bool> is_new(scene_->nodes.size(), true);
  for (size_t old = 0; old < before.nodes.size(); ++old) {
    const uint32_t node = new_node_of_old_[old];
    if (node == kNone)
      add(before.nodes[old]);
    else
      is_new[node] = false;
  }
  for (size_t node = 0; node < is_new.size(); ++node) {
    if (is_new[node]) add(scene_->nodes[node]);
  }
  return changed;
}

// Looks up only those unmatched names that may have a node now.
void PoseState::bind_unmatched(StreamId id, const std::vector<ChangedName>& changed) {
  Stream& stream = streams_[id];
  ReceiveState& wish = receive_states_[id];
  std::vector<uint32_t> found;
  if (stream.unmatched_names.size() <= changed.size()) {
    stream.unmatched_names.visit([&](uint32_t pose) {
      ++names_touched_;
      if (names_.find(wish.names[pose]) != kNone) found.push_back(pose);
      return true;
    });
  } else if (!changed.empty()) {
    if (wish.poses_by_hash.empty()) {
      wish.poses_by_hash.reserve(wish.names.size());
      for (uint32_t pose = 0; pose < wish.names.size(); ++pose)
        wish.poses_by_hash.emplace_back(keyed_hash(wish.names[pose]), pose);
      std::sort(wish.poses_by_hash.begin(), wish.poses_by_hash.end());
    }
    for (const ChangedName& each : changed) {
      ++names_touched_;
      for (auto entry = std::lower_bound(wish.poses_by_hash.begin(), wish.poses_by_hash.end(),
                                         std::pair(each.hash, uint32_t{0}));
           entry != wish.poses_by_hash.end() && entry->first == each.hash; ++entry) {
        if (stream.unmatched_names.contains(entry->second) && wish.names[entry->second] == each.name &&
            names_.find(each.name) != kNone)
          found.push_back(entry->second);
      }
    }
  }
  for (const uint32_t pose : found) {
    if (!stream.unmatched_names.contains(pose)) continue;
    stream.unmatched_names.erase(pose);
    bind(id, pose, names_.find(wish.names[pose]));
  }
}

void PoseState::set_scene(const scene::Scene& scene) {
  const scene::Scene& before = *scene_;
  names_ = NodeNames(scene, file_nodes_);
  new_node_of_old_.assign(before.nodes.size(), kNone);
  for (uint32_t node = 0; node < before.nodes.size(); ++node) {
    const std::string& path = before.nodes[node].path;
    const bool same = node < scene.nodes.size() && scene.nodes[node].path == path;
    new_node_of_old_[node] = same ? node : names_.first_of_path(path);
  }
  ++scene_revision_;
  forget_driver_changes();
  scene_ = &scene;
  rest_ = rest_pose(scene);
  node_drives_.assign(scene.nodes.size(), {});
  const std::vector<uint32_t> drivers =
      std::exchange(driver_stream_of_node_, std::vector<uint32_t>(scene.nodes.size(), kNone));
  const std::vector<uint32_t> driver_poses =
      std::exchange(driver_pose_of_node_, std::vector<uint32_t>(scene.nodes.size(), kNone));
  claims_.clear();

  std::vector<Stream> streams_before(streams_.size());
  std::vector<StreamId> by_age;
  for (StreamId id = 0; id < streams_.size(); ++id) {
    Stream& stream = streams_[id];
    if (receive_states_[id].is_place) receive_states_[id].node_of_pose.clear();
    if (!stream.active) continue;
    by_age.push_back(id);
    const size_t count = receive_states_[id].names.size();
    for (IndexSet Stream::*set :
         {&Stream::unmatched_names, &Stream::conflicting_names, &Stream::contested_names})
      streams_before[id].*set = std::exchange(stream.*set, IndexSet(count));
    stream.scene_node_of_pose.assign(count, kNone);
  }
  // Nodes stay with their driving streams.
  for (uint32_t old = 0; old < drivers.size(); ++old) {
    const uint32_t node = new_node_of_old_[old];
    const StreamId id = drivers[old];
    if (id == kNone || node == kNone || driver_stream_of_node_[node] != kNone) continue;
    driver_stream_of_node_[node] = id;
    driver_pose_of_node_[node] = driver_poses[old];
    if (receive_states_[id].is_place) {
      receive_states_[id].node_of_pose.push_back(node);
    } else {
      receive_states_[id].node_of_pose[driver_poses[old]] = node;
      streams_[id].scene_node_of_pose[driver_poses[old]] = node;
    }
  }
  std::sort(by_age.begin(), by_age.end(),
            [this](StreamId a, StreamId b) { return receive_states_[a].order < receive_states_[b].order; });
  const std::vector<ChangedName> changed = find_changed_names(before);
  for (const StreamId id : by_age) {
    ReceiveState& wish = receive_states_[id];
    for (uint32_t pose = 0; pose < wish.names.size(); ++pose) {
      if (streams_[id].scene_node_of_pose[pose] != kNone) continue;
      const uint32_t old = wish.node_of_pose[pose];
      if (old == kNone) {
        streams_[id].unmatched_names.insert(pose);
        continue;
      }
      const uint32_t same = new_node_of_old_[old];
      bind(id, pose, same != kNone ? same : names_.find(wish.names[pose]));
    }
    bind_unmatched(id, changed);
  }
  // Unchanged sets keep their revision, so that observers see changes only.
  for (const StreamId id : by_age) {
    for (IndexSet Stream::*set :
         {&Stream::unmatched_names, &Stream::conflicting_names, &Stream::contested_names}) {
      const IndexSet& old = streams_before[id].*set;
      (streams_[id].*set).set_revision(old.revision() + ((streams_[id].*set).has_same(old) ? 0 : 1));
    }
  }
  bindings_changed();
}

}  // namespace fire3dv::state
