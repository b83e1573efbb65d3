#include "adapters/gazebo/world/world.h"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <optional>

namespace fire3dv::gazebo {
namespace {

// A dynamic pose topic that is silent for longer leaves all poses to the full one.
constexpr int64_t kDynamicSilence_ns = 500'000'000;
constexpr int64_t kMaxStamp_s = 9'000'000'000;
constexpr size_t kMaxUnknown = 10'000;
constexpr size_t kMaxPoses = 1'000'000;  // of one message

bool is_published(const Entity& entity) {
  if (entity.node.empty()) return false;
  return entity.kind == convert::SdfEntity::model || entity.kind == convert::SdfEntity::link ||
         entity.kind == convert::SdfEntity::light;
}

bool equal(const RigidPose& a, const RigidPose& b) {
  return a.translation == b.translation && a.rotation == b.rotation;
}

std::optional<int64_t> stamp_ns(const pb::Header& header) {
  const int64_t s = header.stamp().sec(), ns = header.stamp().nsec();
  if (s < -kMaxStamp_s || s > kMaxStamp_s || ns < 0 || ns > 999'999'999) return std::nullopt;
  return s * 1'000'000'000 + ns;
}

}  // namespace

void World::index() {
  by_id_.clear();
  for (size_t i = 0; i < items_.size(); ++i) {
    for (size_t k = 0; k < items_[i].entities.size(); ++k) {
      // Entities without ids, and repeated ids: poses move the first.
      if (const uint32_t id = items_[i].entities[k].id; id != 0) by_id_.try_emplace(id, i, k);
    }
  }
}

// Names of nodes of the scene file stay taken: there the file's nodes still have them.
void World::retire(const TopLevel& item) {
  if (item.is_in_file) {
    retired_[item.digest] = item;
  } else {
    for (const Entity& entity : item.entities) names_.release(entity.name);
  }
}

World::Changes World::update(const pb::Scene& scene) {
  std::vector<TopLevel> next = read_entities(scene, warnings_);
  Changes changes;
  std::multimap<std::string, size_t> known;  // by shape, which includes the name
  for (size_t i = 0; i < items_.size(); ++i) known.emplace(items_[i].digest, i);
  std::vector<bool> stays(items_.size(), false);
  std::vector<std::optional<size_t>> before(next.size());
  for (size_t i = 0; i < next.size(); ++i) {
    const auto same = known.find(next[i].digest);
    if (same == known.end()) continue;
    before[i] = same->second;
    stays[same->second] = true;
    known.erase(same);
  }
  for (size_t i = 0; i < items_.size(); ++i) {
    if (stays[i]) continue;
    retire(items_[i]);
    changes.removed.push_back(std::move(items_[i]));
  }
  std::vector<TopLevel*> unnamed;
  for (size_t i = 0; i < next.size(); ++i) {
    const auto retired = before[i] ? retired_.end() : retired_.find(next[i].digest);
    if (!before[i] && retired == retired_.end()) {
      unnamed.push_back(&next[i]);
      changes.added.push_back(i);
      continue;
    }
    const TopLevel& old = before[i] ? items_[*before[i]] : retired->second;
    for (size_t k = 0; k < old.entities.size(); ++k) {
      Entity& entity = next[i].entities[k];
      const Entity& was = old.entities[k];
      entity.name = was.name;
      entity.node = was.node;
      // Pose topics are newer than the answer to a request.
      if (before[i] && was.is_posed && was.id == entity.id) {
        entity.pose = was.pose;
        entity.is_posed = true;
      }
    }
    next[i].is_in_file = old.is_in_file;
    next[i].added_node = old.added_node;
    next[i].is_streamed = old.is_streamed;
    if (before[i]) continue;
    changes.restored.push_back(i);
    retired_.erase(retired);
  }
  name_entities(unnamed, names_);
  items_ = std::move(next);
  index();
  ignored_ids_.clear();
  for (const uint32_t id : unknown_ids_)
    if (!by_id_.contains(id)) ignored_ids_.insert(id);
  unknown_ids_.clear();
  return changes;
}

std::pair<World::Changes, bool> World::remove(const pb::UInt32V& ids) {
  std::set<uint32_t> gone;
  for (int i = 0; i < ids.data_size() && gone.size() < kMaxPoses; ++i) gone.insert(ids.data(i));
  Changes changes;
  std::vector<TopLevel> rest;
  bool whole = true;
  for (TopLevel& item : items_) {
    if (item.id() != 0 && gone.contains(item.id())) {
      retire(item);
      changes.removed.push_back(std::move(item));
      continue;
    }
    whole &= std::none_of(item.entities.begin(), item.entities.end(),
                          [&](const Entity& entity) { return entity.id != 0 && gone.contains(entity.id); });
    rest.push_back(std::move(item));
  }
  items_ = std::move(rest);
  index();
  return {std::move(changes), whole};
}

void World::forget_times() {
  last_ = {};
  frame_ = {};
  dynamic_ids_.clear();
  ignored_ids_.clear();
}

World::PoseResult World::apply(const pb::PoseV& message, PoseTopic topic, int64_t now_ns) {
  PoseResult result;
  const std::optional<int64_t> stamp = stamp_ns(message.header());
  if (!stamp || static_cast<size_t>(message.pose_size()) > kMaxPoses) {
    ++invalid_poses_;
    return result;
  }
  Last& last = last_[static_cast<size_t>(topic)];
  const Last& dynamic = last_[static_cast<size_t>(PoseTopic::dynamic)];
  if (last.is_set && *stamp < last.sim_time_ns) {
    result.is_reset = true;
    forget_times();
  }
  last = {true, *stamp, now_ns};
  // Poses of both topics are of different times: those of moving models come from the dynamic one alone.
  const bool defers =
      topic == PoseTopic::full && dynamic.is_set && now_ns - dynamic.arrival_ns <= kDynamicSilence_ns;
  if (topic == PoseTopic::dynamic) dynamic_ids_.clear();
  bool changed = false;
  for (const pb::Pose& pose : message.pose()) {
    const uint32_t id = pose.id();
    if (topic == PoseTopic::dynamic) dynamic_ids_.push_back(id);
    if (defers && std::binary_search(dynamic_ids_.begin(), dynamic_ids_.end(), id)) continue;
    const auto found = by_id_.find(id);
    if (found == by_id_.end()) {
      if (id != 0 && !ignored_ids_.contains(id) && unknown_ids_.size() < kMaxUnknown) {
        unknown_ids_.insert(id);
        result.has_unknown = true;
      }
      continue;
    }
    const std::optional<RigidPose> rigid = rigid_pose(pose);
    if (!rigid) {
      ++invalid_poses_;
      continue;
    }
    Entity& entity = items_[found->second.first].entities[found->second.second];
    entity.is_posed = true;
    if (equal(entity.pose, *rigid)) continue;
    entity.pose = *rigid;
    changed |= is_published(entity);
  }
  std::sort(dynamic_ids_.begin(), dynamic_ids_.end());
  result.sim_time_ns = defers && frame_.is_set ? frame_.sim_time_ns : *stamp;
  result.is_frame = changed || (!defers && (!frame_.is_set || frame_.sim_time_ns != *stamp));
  if (result.is_frame) frame_ = {true, result.sim_time_ns, now_ns};
  return result;
}

std::vector<std::string> World::node_names() const {
  std::vector<std::string> names;
  for (const TopLevel& item : items_) {
    if (!item.is_streamed) continue;
    for (const Entity& entity : item.entities)
      if (is_published(entity)) names.push_back(entity.node);
  }
  return names;
}

void World::write_poses(std::vector<float>& poses) const {
  poses.clear();
  std::vector<RigidPose> globals;
  for (const TopLevel& item : items_) {
    if (!item.is_streamed) continue;
    globals.clear();
    for (const Entity& entity : item.entities) {
      globals.push_back(entity.parent == kNoParent ? entity.pose : globals[entity.parent] * entity.pose);
      if (!is_published(entity)) continue;
      const glm::dmat3 linear = glm::mat3_cast(globals.back().rotation);
      for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) poses.push_back(static_cast<float>(linear[column][row]));
        poses.push_back(static_cast<float>(globals.back().translation[row]));
      }
    }
  }
}

}  // namespace fire3dv::gazebo
