#include "renderer/state/node_bindings.h"

#include <algorithm>

#include "base/random.h"
#include "renderer/scene/model/math.h"

namespace fire3dv::state {
namespace {

constexpr uint64_t kRunMask = (uint64_t{1} << 24) - 1;  // reconnection counter in an age; see age_rank()
constexpr IndexSet BoundNames::*kNameSets[] = {&BoundNames::unmatched_names, &BoundNames::conflicting_names,
                                               &BoundNames::contested_names};

}  // namespace

NodeBindings::NodeBindings(const scene::Scene& scene, BoundNamesOf bound_names)
    : scene_(&scene),
      file_nodes_(static_cast<uint32_t>(scene.nodes.size())),
      bound_names_(std::move(bound_names)),
      node_names_(scene, file_nodes_),
      driver_stream_of_node_(scene.nodes.size(), kNone),
      driver_pose_of_node_(scene.nodes.size(), kNone),
      drives_(scene.nodes.size()) {}

std::vector<NodeBindings::Reservation>::iterator NodeBindings::find_reservation(uint64_t age) {
  return std::find_if(reservations_.begin(), reservations_.end(), [age](const Reservation& reservation) {
    return reservation.age == age && reservation.slot != kNone;
  });
}

NodeBindings::Slot NodeBindings::take_slot(uint64_t reservation) {
  const auto reserved = reservation != 0 ? find_reservation(reservation) : reservations_.end();
  if (reserved != reservations_.end() && (reservation & kRunMask) != kRunMask) {
    const StreamId id = std::exchange(reserved->slot, kNone);
    if (!reserved->edited_epoch) reservations_.erase(reserved);
    return {id, true};
  }
  const auto unused =
      std::find_if(slots_.begin(), slots_.end(), [](const Entry& entry) { return entry.use == Use::free; });
  return {static_cast<StreamId>(unused - slots_.begin()), false};
}

void NodeBindings::add(const Slot& slot, uint64_t reservation, const wire::StreamDescription& description) {
  const StreamId id = slot.id;
  if (id == slots_.size()) slots_.emplace_back();
  Entry& entry = slots_[id];
  const std::vector<uint32_t> reserved = std::move(entry.node_of_pose);  // nodes of the reservation
  const size_t count = description.node_names.size();
  entry = Entry{};
  entry.use = Use::stream;
  entry.age = slot.is_reserved ? reservation + 1 : next_rank_++ << 24;
  entry.names = description.node_names;
  // A list of another length is meaningless (the decoder refuses it); the documented default is identity.
  const size_t offsets = description.body_from_node.size();
  if (offsets == 1 || offsets == count) entry.body_from_node = description.body_from_node;
  entry.node_of_pose.assign(count, kNone);
  for (uint32_t pose = 0; pose < count; ++pose) bind(id, pose, node_names_.find(entry.names[pose]));
  for (const uint32_t node : reserved) {  // reserved nodes that it does not claim any more
    if (driver_stream_of_node_[node] == id && driver_pose_of_node_[node] == kNone) release_node(node);
  }
  bindings_changed();
}

void NodeBindings::remove(StreamId id, std::optional<uint64_t> edited_epoch) {
  if (edited_epoch) ended_edits_.push_back({id, *edited_epoch, slots_[id].age});
  drop_claims(id);
  for (const uint32_t node : bound_names_(id).scene_node_of_pose) {
    if (node != kNone) release_node(node);
  }
  slots_[id] = Entry{};
  bindings_changed();
}

uint64_t NodeBindings::suspend(StreamId id, int64_t until_ns, std::optional<uint64_t> edited_epoch) {
  const Reservation reservation{slots_[id].age, until_ns, id, edited_epoch};
  if (edited_epoch) ended_edits_.push_back({id, *edited_epoch, reservation.age, true});
  drop_claims(id);
  std::vector<uint32_t> nodes;
  for (const uint32_t node : bound_names_(id).scene_node_of_pose) {
    if (node == kNone) continue;
    driver_pose_of_node_[node] = kNone;
    nodes.push_back(node);
  }
  nodes.shrink_to_fit();
  slots_[id] = Entry{};
  slots_[id].use = Use::reservation;
  slots_[id].age = reservation.age;
  slots_[id].node_of_pose = std::move(nodes);
  bindings_changed();
  add_reservation(reservation);
  return reservation.age;
}

// Each rank has one reservation of nodes and one of edits. Beyond kMaxReservations the youngest rank expires.
void NodeBindings::add_reservation(const Reservation& reservation) {
  if (reservation.edited_epoch) {
    std::erase_if(reservations_, [&](const Reservation& other) {
      if (age_rank(other.age) != age_rank(reservation.age)) return false;
      end_reservation(other);
      return true;
    });
  }
  reservations_.push_back(reservation);
  if (reservations_.size() <= kMaxReservations) return;
  const auto youngest =
      std::max_element(reservations_.begin(), reservations_.end(),
                       [](const Reservation& a, const Reservation& b) { return a.age < b.age; });
  const Reservation last = *youngest;
  reservations_.erase(youngest);
  end_reservation(last);
}

void NodeBindings::pass_reserved_nodes(uint64_t reservation, StreamId id) {
  const auto found = find_reservation(reservation);
  if (found == reservations_.end()) return;
  if (found->edited_epoch) ended_edits_.push_back({found->slot, *found->edited_epoch, found->age});
  found->edited_epoch.reset();
  std::erase_if(slots_[found->slot].node_of_pose, [&](uint32_t node) {
    for (auto claim = claims_.lower_bound({node, 0, 0, 0}); claim != claims_.end() && claim->node == node;
         ++claim) {
      if (claim->stream != id) continue;
      const uint32_t pose = claim->pose;
      ++name_lookups_;
      claims_.erase(claim);
      bound_names_(id).conflicting_names.erase(pose);
      set_driver(id, pose, node);
      return true;
    }
    return false;
  });
  bindings_changed();
}

void NodeBindings::expire(int64_t now_ns) {
  std::erase_if(reservations_, [&](const Reservation& reservation) {
    if (reservation.until_ns > now_ns) return false;
    end_reservation(reservation);
    return true;
  });
}

void NodeBindings::end_reservation(const Reservation& reservation) {
  if (reservation.edited_epoch)
    ended_edits_.push_back({reservation.slot, *reservation.edited_epoch, reservation.age});
  if (reservation.slot == kNone) return;
  for (const uint32_t node : slots_[reservation.slot].node_of_pose) {
    if (driver_stream_of_node_[node] == reservation.slot) release_node(node);
  }
  slots_[reservation.slot] = Entry{};
  bindings_changed();
}

std::optional<uint64_t> NodeBindings::age_of_driver(uint32_t node) const {
  const uint32_t stream = driver_stream_of_node_[node];
  return stream == kNone ? std::nullopt : std::optional(slots_[stream].age);
}

uint64_t NodeBindings::oldest_age() const {
  uint64_t oldest = UINT64_MAX;
  for (const Entry& entry : slots_) {
    if (entry.use != Use::free) oldest = std::min(oldest, entry.age);
  }
  return oldest;
}

void NodeBindings::begin_driving(StreamId id) {
  slots_[id].is_driving = true;
  drives_changed();
}

// A node follows its nearest driven ancestor or itself; rest transforms apply below. Parents precede
// children.
const std::vector<NodeDrive>& NodeBindings::drives(const RestPose& rest) const {
  if (!std::exchange(are_drives_stale_, false)) return drives_;
  for (uint32_t node = 0; node < scene_->nodes.size(); ++node) {
    NodeDrive& drive = drives_[node];
    drive = NodeDrive{};
    const uint32_t stream = driver_stream_of_node_[node];
    if (stream != kNone && slots_[stream].is_driving) {
      const std::vector<wire::Affine3x4>& offsets = slots_[stream].body_from_node;
      drive.stream = stream;
      drive.pose_index = driver_pose_of_node_[node];
      if (!offsets.empty()) drive.body_from_node = offsets[offsets.size() == 1 ? 0 : drive.pose_index];
      continue;
    }
    const uint32_t parent = scene_->nodes[node].parent;
    if (parent == scene::kNone || drives_[parent].stream == kNone) {
      drive.body_from_node = scene::to_affine(rest.world_from_node[node]);
      continue;
    }
    drive = drives_[parent];
    drive.body_from_node =
        scene::to_affine(scene::to_mat4(drive.body_from_node) * rest.parent_from_node[node]);
  }
  return drives_;
}

std::vector<std::string> NodeBindings::names_at(StreamId id, const IndexSet& indices,
                                                size_t max_bytes) const {
  std::vector<std::string> names;
  size_t bytes = 0;
  indices.visit([&](uint32_t index) {
    const std::string& name = slots_[id].names[index];
    bytes += name.size() + 8;
    if (bytes > max_bytes) return false;
    names.push_back(name);
    return true;
  });
  return names;
}

void NodeBindings::bind(StreamId id, uint32_t pose, uint32_t node) {
  ++name_lookups_;
  slots_[id].node_of_pose[pose] = node;
  if (node == kNone) return bound_names_(id).unmatched_names.insert(pose);
  const StreamId driver = driver_stream_of_node_[node];
  const uint32_t driver_pose = driver_pose_of_node_[node];
  if (driver == kNone || (driver == id && driver_pose == kNone)) return set_driver(id, pose, node);
  claims_.insert({node, slots_[id].age, pose, id});
  bound_names_(id).conflicting_names.insert(pose);
  // The driver reports each contested node once, by its own name. Two names within one stream are no contest.
  if (driver != id && driver_pose != kNone) bound_names_(driver).contested_names.insert(driver_pose);
}

void NodeBindings::set_driver(StreamId id, uint32_t pose, uint32_t node) {
  record_driver_change(node);
  driver_stream_of_node_[node] = id;
  driver_pose_of_node_[node] = pose;
  bound_names_(id).scene_node_of_pose[pose] = node;
  if (is_contested(node, id)) bound_names_(id).contested_names.insert(pose);
}

bool NodeBindings::is_contested(uint32_t node, StreamId driver) const {
  for (auto claim = claims_.lower_bound({node, 0, 0, 0}); claim != claims_.end() && claim->node == node;
       ++claim) {
    if (claim->stream != driver) return true;
  }
  return false;
}

// The node's driver leaves it: the oldest claim is next.
void NodeBindings::release_node(uint32_t node) {
  ++name_lookups_;
  record_driver_change(node);
  driver_stream_of_node_[node] = driver_pose_of_node_[node] = kNone;
  const auto next = claims_.lower_bound({node, 0, 0, 0});
  if (next == claims_.end() || next->node != node) return;
  const Claim claim = *next;
  claims_.erase(next);
  bound_names_(claim.stream).conflicting_names.erase(claim.pose);
  set_driver(claim.stream, claim.pose, node);
}

// The list is bounded: observers that poll less often than all nodes change must visit all nodes.
void NodeBindings::record_driver_change(uint32_t node) {
  constexpr size_t kMinChanges = 1024;
  if (driver_changes_.size() >= std::max(kMinChanges, driver_stream_of_node_.size())) reset_driver_changes();
  driver_changes_.push_back(node);
}

void NodeBindings::reset_driver_changes() {
  driver_changes_begin_ = driver_revision() + 1;
  driver_changes_.clear();
}

std::optional<std::span<const uint32_t>> NodeBindings::driver_changes_since(uint64_t revision) const {
  if (revision < driver_changes_begin_ || revision > driver_revision()) return std::nullopt;
  return std::span(driver_changes_).subspan(revision - driver_changes_begin_);
}

void NodeBindings::drop_claim(StreamId id, uint32_t pose, uint32_t node) {
  claims_.erase({node, slots_[id].age, pose, id});
  const StreamId driver = driver_stream_of_node_[node];
  const uint32_t driver_pose = driver_pose_of_node_[node];
  if (driver != kNone && driver != id && driver_pose != kNone && !is_contested(node, driver))
    bound_names_(driver).contested_names.erase(driver_pose);
}

void NodeBindings::drop_claims(StreamId id) {
  bound_names_(id).conflicting_names.visit([&](uint32_t pose) {
    ++name_lookups_;
    drop_claim(id, pose, slots_[id].node_of_pose[pose]);
    return true;
  });
}

void NodeBindings::bindings_changed() {
  ++revision_;
  drives_changed();
}

void NodeBindings::drives_changed() {
  ++drive_revision_;
  are_drives_stale_ = true;
}

// Returns names and paths of nodes that only one of both scenes has; all other look-ups are unchanged.
std::vector<NodeBindings::ChangedName> NodeBindings::find_changed_names(const scene::Scene& before) const {
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
void NodeBindings::bind_unmatched(StreamId id, const std::vector<ChangedName>& changed) {
  BoundNames& bound = bound_names_(id);
  Entry& entry = slots_[id];
  std::vector<uint32_t> found;
  if (bound.unmatched_names.size() <= changed.size()) {
    bound.unmatched_names.visit([&](uint32_t pose) {
      ++name_lookups_;
      if (node_names_.find(entry.names[pose]) != kNone) found.push_back(pose);
      return true;
    });
  } else if (!changed.empty()) {
    if (entry.poses_by_hash.empty()) {
      entry.poses_by_hash.reserve(entry.names.size());
      for (uint32_t pose = 0; pose < entry.names.size(); ++pose)
        entry.poses_by_hash.emplace_back(keyed_hash(entry.names[pose]), pose);
      std::sort(entry.poses_by_hash.begin(), entry.poses_by_hash.end());
    }
    for (const ChangedName& each : changed) {
      ++name_lookups_;
      for (auto named = std::lower_bound(entry.poses_by_hash.begin(), entry.poses_by_hash.end(),
                                         std::pair(each.hash, uint32_t{0}));
           named != entry.poses_by_hash.end() && named->first == each.hash; ++named) {
        if (bound.unmatched_names.contains(named->second) && entry.names[named->second] == each.name &&
            node_names_.find(each.name) != kNone)
          found.push_back(named->second);
      }
    }
  }
  for (const uint32_t pose : found) {
    if (!bound.unmatched_names.contains(pose)) continue;
    bound.unmatched_names.erase(pose);
    bind(id, pose, node_names_.find(entry.names[pose]));
  }
}

// Empties the bindings of all streams; returns the streams by age. `before` receives their name sets.
std::vector<StreamId> NodeBindings::clear_bindings(std::vector<BoundNames>& before) {
  claims_.clear();
  before.resize(slots_.size());
  std::vector<StreamId> by_age;
  for (StreamId id = 0; id < slots_.size(); ++id) {
    if (slots_[id].use == Use::reservation) slots_[id].node_of_pose.clear();
    if (slots_[id].use != Use::stream) continue;
    by_age.push_back(id);
    BoundNames& bound = bound_names_(id);
    const size_t count = slots_[id].names.size();
    for (IndexSet BoundNames::*set : kNameSets) before[id].*set = std::exchange(bound.*set, IndexSet(count));
    bound.scene_node_of_pose.assign(count, kNone);
  }
  std::sort(by_age.begin(), by_age.end(),
            [this](StreamId a, StreamId b) { return slots_[a].age < slots_[b].age; });
  return by_age;
}

// Nodes stay with the streams that drove them in the scene before.
void NodeBindings::restore_drivers(const std::vector<uint32_t>& drivers,
                                   const std::vector<uint32_t>& driver_poses) {
  for (uint32_t old = 0; old < drivers.size(); ++old) {
    const uint32_t node = new_node_of_old_[old];
    const StreamId id = drivers[old];
    if (id == kNone || node == kNone || driver_stream_of_node_[node] != kNone) continue;
    driver_stream_of_node_[node] = id;
    driver_pose_of_node_[node] = driver_poses[old];
    if (slots_[id].use == Use::reservation) {
      slots_[id].node_of_pose.push_back(node);
    } else {
      slots_[id].node_of_pose[driver_poses[old]] = node;
      bound_names_(id).scene_node_of_pose[driver_poses[old]] = node;
    }
  }
}

void NodeBindings::set_scene(const scene::Scene& scene, std::optional<uint32_t> file_nodes) {
  file_nodes_ = file_nodes.value_or(file_nodes_);
  const scene::Scene& before = *scene_;
  node_names_ = NodeNames(scene, file_nodes_);
  new_node_of_old_.assign(before.nodes.size(), kNone);
  for (uint32_t node = 0; node < before.nodes.size(); ++node) {
    const std::string& path = before.nodes[node].path;
    const bool same = node < scene.nodes.size() && scene.nodes[node].path == path;
    new_node_of_old_[node] = same ? node : node_names_.first_of_path(path);
  }
  ++scene_revision_;
  reset_driver_changes();
  scene_ = &scene;
  drives_.assign(scene.nodes.size(), {});
  const std::vector<uint32_t> drivers =
      std::exchange(driver_stream_of_node_, std::vector<uint32_t>(scene.nodes.size(), kNone));
  const std::vector<uint32_t> driver_poses =
      std::exchange(driver_pose_of_node_, std::vector<uint32_t>(scene.nodes.size(), kNone));
  std::vector<BoundNames> bound_before;
  const std::vector<StreamId> by_age = clear_bindings(bound_before);
  restore_drivers(drivers, driver_poses);
  const std::vector<ChangedName> changed = find_changed_names(before);
  for (const StreamId id : by_age) {
    BoundNames& bound = bound_names_(id);
    const Entry& entry = slots_[id];
    for (uint32_t pose = 0; pose < entry.names.size(); ++pose) {
      if (bound.scene_node_of_pose[pose] != kNone) continue;
      const uint32_t old = entry.node_of_pose[pose];
      if (old == kNone) {
        bound.unmatched_names.insert(pose);
        continue;
      }
      const uint32_t same = new_node_of_old_[old];
      bind(id, pose, same != kNone ? same : node_names_.find(entry.names[pose]));
    }
    bind_unmatched(id, changed);
  }
  // Unchanged sets keep their revision, so that observers see changes only.
  for (const StreamId id : by_age) {
    BoundNames& bound = bound_names_(id);
    for (IndexSet BoundNames::*set : kNameSets) {
      const IndexSet& old = bound_before[id].*set;
      (bound.*set).set_revision(old.revision() + ((bound.*set).has_same(old) ? 0 : 1));
    }
  }
  bindings_changed();
}

}  // namespace fire3dv::state
