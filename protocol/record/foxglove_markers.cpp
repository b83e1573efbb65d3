#include "protocol/record/foxglove_markers.h"

#include "protocol/record/foxglove.h"
#include "protocol/record/foxglove_encoding.h"
#include "protocol/record/foxglove_entities.h"
#include "protocol/wire/limits.h"
#include "scene_update_generated.h"

namespace fire3dv::record {
namespace {

using flatbuffers::Offset;
using wire::Affine3x4d;
using wire::Marker;
using wire::MarkerKind;

constexpr size_t kMaxNameBytes = size_t{8} << 20;

// id empty: of all entities of the channel.
wire::Bytes deletion(const std::string& id, uint64_t time_ns) {
  auto builder = builder_that_writes_all(256);
  const foxglove::Time time = time_of(time_ns);
  const auto text = builder.CreateString(id);
  const auto entry = foxglove::CreateSceneEntityDeletion(
      builder, &time,
      id.empty() ? foxglove::SceneEntityDeletionType::ALL : foxglove::SceneEntityDeletionType::MATCHING_ID,
      text);
  const auto deletions = builder.CreateVector(&entry, 1);
  const auto entities = builder.CreateVector(std::vector<Offset<foxglove::SceneEntity>>());
  builder.Finish(foxglove::CreateSceneUpdate(builder, deletions, entities));
  const auto bytes = bytes_of(builder);
  return {bytes.begin(), bytes.end()};
}

FoxgloveMessage removal(const std::string& name, bool is_cloud, uint64_t time_ns) {
  if (is_cloud) return {name, encode_cloud({}, std::string(kRootFrame), {}, time_ns)};
  return {{}, deletion(name, time_ns)};
}

}  // namespace

std::vector<std::string> foxglove_frame_ids(const wire::StreamDescription& description) {
  std::vector<std::string> ids = description.node_names;
  // Viewers reject a frame that is its own parent and a frame without a name.
  for (size_t i = 0; i < ids.size(); ++i)
    if (ids[i].empty() || ids[i] == kRootFrame) ids[i] += "/node_" + std::to_string(i);
  return ids;
}

void FoxgloveMarkers::describe(const wire::StreamDescription& description) {
  frame_ids_ = foxglove_frame_ids(description);
  nodes_.clear();
  for (size_t i = 0; i < description.node_names.size(); ++i) nodes_.emplace(description.node_names[i], i);
  body_from_node_ = description.body_from_node;
  root_from_stream_ = z_up_from(description.world_from_stream);
  stream_scale_ = scale_of(description.world_from_stream);
  sim_time_ns_ = INT64_MIN;
  shown_.clear();
  name_bytes_ = 0;
  ends_.clear();
}

FoxgloveMarkers::EntityFrame FoxgloveMarkers::entity_frame(const Marker& marker) const {
  if (marker.parent.empty())
    return {std::string(kRootFrame), product(root_from_stream_, marker.parent_from_marker)};
  const auto node = nodes_.find(marker.parent);
  if (node == nodes_.end())
    return {marker.parent == kRootFrame ? marker.parent + "/node" : marker.parent,
            product({}, marker.parent_from_marker)};
  // The frame's transform has no scale: that of the stream is applied here.
  const double s = stream_scale_;
  Affine3x4d frame_from_node{{s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0}};
  if (!body_from_node_.empty())
    frame_from_node =
        product(frame_from_node, body_from_node_[body_from_node_.size() > 1 ? node->second : 0]);
  return {frame_ids_[node->second], product(frame_from_node, marker.parent_from_marker)};
}

void FoxgloveMarkers::forget(std::map<std::string, Shown>::iterator entry) {
  if (entry->second.end_ns) ends_.erase({*entry->second.end_ns, entry->first});
  name_bytes_ -= entry->first.size();
  shown_.erase(entry);
}

std::vector<FoxgloveMessage> FoxgloveMarkers::clear(const std::string& name, uint64_t time_ns) {
  const auto known = shown_.find(name);
  if (known == shown_.end()) return {};
  const bool is_cloud = known->second.is_cloud;
  forget(known);
  std::vector<FoxgloveMessage> result;
  result.push_back(removal(name, is_cloud, time_ns));
  return result;
}

std::vector<FoxgloveMessage> FoxgloveMarkers::clear_all(uint64_t time_ns) {
  std::vector<FoxgloveMessage> result;
  bool has_entities = false;
  for (const auto& [name, shown] : shown_) {
    has_entities |= !shown.is_cloud;
    if (shown.is_cloud) result.push_back(removal(name, true, time_ns));
  }
  if (has_entities) result.push_back({{}, deletion({}, time_ns)});
  shown_.clear();
  name_bytes_ = 0;
  ends_.clear();
  return result;
}

std::vector<FoxgloveMessage> FoxgloveMarkers::advance(int64_t sim_time_ns, uint64_t time_ns) {
  sim_time_ns_ = sim_time_ns;
  std::vector<FoxgloveMessage> result;
  while (!ends_.empty() && ends_.begin()->first < sim_time_ns) {
    const std::string name = ends_.begin()->second;
    for (FoxgloveMessage& message : clear(name, time_ns)) result.push_back(std::move(message));
  }
  return result;
}

std::vector<FoxgloveMessage> FoxgloveMarkers::set(const std::string& name, const Marker& marker,
                                                  uint64_t time_ns) {
  std::optional<int64_t> end_ns;
  if (marker.lifetime_ns != 0) {
    int64_t end = 0;
    if (marker.lifetime_ns > static_cast<uint64_t>(INT64_MAX) ||
        __builtin_add_overflow(marker.sim_time_ns, static_cast<int64_t>(marker.lifetime_ns), &end))
      end = INT64_MAX;
    end_ns = end;
  }
  const bool is_convertible = marker.kind < MarkerKind::images;  // kinds of a later version are unknown
  if (marker.kind == MarkerKind::images) ++left_out_;            // they have no equivalent
  const bool is_over = end_ns && *end_ns < sim_time_ns_;
  if (!is_convertible || is_over || marker.positions.empty()) return clear(name, time_ns);
  const bool is_full = shown_.size() >= wire::kMaxSceneEdits || name_bytes_ + name.size() > kMaxNameBytes;
  if (max_bytes(marker) > kMaxMarkerBytes || (is_full && !shown_.contains(name))) {
    ++left_out_;
    return clear(name, time_ns);
  }
  std::vector<FoxgloveMessage> result;
  const bool is_cloud = marker.kind == MarkerKind::points;
  if (const auto known = shown_.find(name); known != shown_.end()) {
    if (known->second.is_cloud != is_cloud) result.push_back(removal(name, known->second.is_cloud, time_ns));
    forget(known);
  }
  name_bytes_ += name.size();
  shown_[name] = {is_cloud, end_ns};
  if (end_ns) ends_.insert({*end_ns, name});
  const EntityFrame entity = entity_frame(marker);
  if (is_cloud)
    result.push_back({name, encode_cloud(marker, entity.frame_id, entity.frame_from_marker, time_ns)});
  else
    result.push_back({{}, encode_entity(marker, name, entity.frame_id, entity.frame_from_marker, time_ns)});
  return result;
}

}  // namespace fire3dv::record
