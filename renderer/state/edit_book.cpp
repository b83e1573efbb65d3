#include "renderer/state/edit_book.h"

#include <algorithm>
#include <cstddef>

#include "renderer/scene/files.h"
#include "renderer/scene/replaced_vertices.h"

namespace fire3dv::state {
namespace {

// What the wire does not speak of stays as the file has it: how large the source is, and its name.
scene::Light light_of(const wire::Light& from, const scene::Scene& scene, uint32_t node) {
  scene::Light light;
  if (scene.nodes[node].light != scene::kNone) light = scene.lights[scene.nodes[node].light];
  light.type = from.kind == wire::LightKind::directional ? scene::LightType::directional
               : from.kind == wire::LightKind::point     ? scene::LightType::point
                                                         : scene::LightType::spot;
  light.color = {from.color_rgb[0], from.color_rgb[1], from.color_rgb[2]};
  light.intensity = from.intensity;
  light.range_m = from.range_m;
  light.inner_cone_rad = from.inner_cone_rad;
  light.outer_cone_rad = from.outer_cone_rad;
  light.casts_shadow = from.casts_shadow;
  return light;
}

scene::Camera camera_of(const wire::Camera& from, const scene::Scene& scene, uint32_t node) {
  scene::Camera camera;
  if (scene.nodes[node].camera != scene::kNone) camera.name = scene.cameras[scene.nodes[node].camera].name;
  camera.vertical_fov_rad = from.vertical_fov_rad;
  camera.near_m = from.near_m;
  camera.far_m = from.far_m;
  camera.exposure = from.exposure;
  return camera;
}

// The node and all below it are not shown with this edit.
bool takes_away(const wire::EditValue& value) {
  const auto* visible = std::get_if<wire::Visible>(&value);
  return std::holds_alternative<wire::NodeRemoved>(value) || (visible && !visible->visible);
}

}  // namespace

void EditBook::take(std::vector<SceneChanges> changes, const NodeNames* file_names) {
  std::vector<std::string> added;
  for (SceneChanges& change : changes) {
    if (change.ended) {
      const auto stream = streams_.find(change.age);
      if (stream == streams_.end()) continue;
      if (change.may_return) {
        reserve(stream->second);
      } else {
        streams_.erase(stream);
      }
      ++wanted_revision_;
      continue;
    }
    StreamBook& stream = streams_[change.age];
    stream.id = change.stream;
    stream.budget = change.budget;
    for (size_t i = 0; i < change.edits.size(); ++i) {
      wire::SceneEdit& edit = change.edits[i];
      if (std::holds_alternative<wire::NodeAdded>(edit.value)) added.push_back(edit.node);
      keep(stream, std::move(edit),
           i < change.charges.size() ? std::move(change.charges[i]) : BudgetCharge());
    }
  }
  for (const std::string& name : added) settle_name(name, file_names);
}

// Undoes what the stream changed, and leaves its nodes to it alone.
void EditBook::reserve(StreamBook& stream) {
  for (const auto& [key, kept] : stream.edits) {
    if (kept.bound_node != kNone) stream.reserved_nodes.push_back(kept.bound_node);
  }
  stream.edits.clear();
  std::sort(stream.reserved_nodes.begin(), stream.reserved_nodes.end());
  const auto end = std::unique(stream.reserved_nodes.begin(), stream.reserved_nodes.end());
  stream.reserved_nodes.erase(end, stream.reserved_nodes.end());
  stream.reserved_nodes.shrink_to_fit();
  stream.budget.reset();
}

void EditBook::keep(StreamBook& stream, wire::SceneEdit&& edit, BudgetCharge charge) {
  const Key key(edit.node, edit.property);
  if (edit.property == wire::Property::node) ++wanted_revision_;
  const auto known = stream.edits.find(key);
  if (known != stream.edits.end()) finish(stream, known->second);  // nobody will see it any more
  if (std::holds_alternative<wire::Cleared>(edit.value)) {
    if (known != stream.edits.end()) stream.edits.erase(known);
    return;
  }
  Kept& kept = stream.edits[key];
  const uint32_t bound_node = kept.bound_node;
  const bool is_searched = kept.is_searched;
  kept = {};
  kept.bound_node = bound_node;
  kept.is_searched = is_searched;
  kept.charge = std::move(charge);
  kept.edit = std::move(edit);
  if (auto* node = std::get_if<wire::NodeAdded>(&kept.edit.value)) {
    kept.node = std::make_shared<const wire::NodeAdded>(std::move(*node));
    kept.finished = false;
  } else if (auto* vertices = std::get_if<wire::Vertices>(&kept.edit.value)) {
    auto replaced = std::make_shared<scene::ReplacedVertices>();
    replaced->positions.reserve(vertices->positions.size());
    replaced->normals.reserve(vertices->normals.size());
    for (const auto& p : vertices->positions) replaced->positions.emplace_back(p[0], p[1], p[2]);
    for (const auto& n : vertices->normals) replaced->normals.emplace_back(n[0], n[1], n[2]);
    *vertices = {};
    kept.vertices = std::move(replaced);
    kept.finished = false;
  }
}

// Of several streams that add a node of one name the oldest does, and none where the file has the name.
void EditBook::settle_name(const std::string& name, const NodeNames* file_names) {
  const Key key(name, wire::Property::node);
  const bool in_file = file_names && file_names->file_has(name);
  bool taken = in_file;
  for (auto& [age, stream] : streams_) {
    const auto kept = stream.edits.find(key);
    if (kept == stream.edits.end() || !kept->second.node || kept->second.refused) continue;
    if (taken)
      refuse(stream, kept->second,
             in_file ? "the scene's file has that name already" : "an older stream adds a node of that name");
    taken = true;
  }
}

void EditBook::finish(StreamBook& stream, Kept& kept) {
  if (std::exchange(kept.finished, true)) return;
  finished_.push_back({stream.id, kept.edit.epoch, kept.edit.version});
}

std::vector<WantedNode> EditBook::wanted_nodes() const {
  std::vector<WantedNode> wanted;
  for (const auto& [age, stream] : streams_) {
    const auto first = static_cast<std::ptrdiff_t>(wanted.size());
    for (const auto& [key, kept] : stream.edits) {
      if (kept.node && !kept.refused)
        wanted.push_back({age, kept.edit.version, key.first, kept.node, stream.budget});
    }
    std::sort(wanted.begin() + first, wanted.end(),
              [](const WantedNode& a, const WantedNode& b) { return a.version < b.version; });
  }
  return wanted;
}

EditBook::Kept* EditBook::find(const WantedNode& node) {
  const auto stream = streams_.find(node.age);
  if (stream == streams_.end()) return nullptr;
  const auto kept = stream->second.edits.find(Key(node.name, wire::Property::node));
  const bool same = kept != stream->second.edits.end() && kept->second.edit.version == node.version;
  return same ? &kept->second : nullptr;  // else another edit has taken its place meanwhile
}

bool EditBook::is_wanted(const WantedNode& node) const {
  const auto stream = streams_.find(node.age);
  if (stream == streams_.end()) return false;
  const auto kept = stream->second.edits.find(Key(node.name, wire::Property::node));
  return kept != stream->second.edits.end() && kept->second.edit.version == node.version &&
         kept->second.node && !kept->second.refused;
}

void EditBook::node_is_there(const WantedNode& node) {
  if (Kept* const kept = find(node)) finish(streams_[node.age], *kept);
}

void EditBook::refuse_node(const WantedNode& node, const std::string& reason) {
  if (Kept* const kept = find(node)) refuse(streams_[node.age], *kept, reason);
}

void EditBook::refuse(StreamBook& stream, Kept& kept, const std::string& reason) {
  constexpr uint32_t kMaxTold = 8;  // of one stream
  if (std::exchange(kept.refused, true)) return;
  ++faults_.refused;
  ++wanted_revision_;
  if (++stream.refusals_told <= kMaxTold)
    notes_.push_back("the node " + scene::quote(kept.edit.node) + " of stream \"" + stream.name +
                     "\" is not added: " + reason +
                     (stream.refusals_told == kMaxTold ? "; further nodes are refused without a word" : ""));
  finish(stream, kept);
}

// Edits stay with their nodes when the scene is replaced, whatever names the new one has.
void EditBook::bind(const PoseState& poses) {
  const uint64_t revision = poses.scene_revision();
  const bool is_next = revision == scene_revision_ + 1, is_same = revision == scene_revision_;
  const std::vector<uint32_t>& new_node = poses.new_node_of_old();
  const auto follow = [&](uint32_t node) {
    if (is_same) return node;
    return is_next && node < new_node.size() ? new_node[node] : kNone;
  };
  scene_revision_ = revision;
  for (auto& [age, stream] : streams_) {
    if (!is_same) {
      for (uint32_t& node : stream.reserved_nodes) node = follow(node);
      std::erase(stream.reserved_nodes, kNone);
    }
    for (auto& [key, kept] : stream.edits) {
      kept.bound_node = kept.refused ? kNone : follow(kept.bound_node);
      if (kept.refused || kept.bound_node != kNone || (is_same && kept.is_searched)) continue;
      kept.bound_node = poses.names().find(key.first);
      kept.is_searched = true;
    }
  }
}

// The oldest stream that edits each node.
EditBook::Owners EditBook::find_editors(size_t node_count) const {
  Owners editors(node_count, UINT64_MAX);
  for (const auto& [age, stream] : streams_) {
    for (const uint32_t node : stream.reserved_nodes) editors[node] = std::min(editors[node], age);
    for (const auto& [key, kept] : stream.edits) {
      if (kept.bound_node != kNone) editors[kept.bound_node] = std::min(editors[kept.bound_node], age);
    }
  }
  return editors;
}

// Ages of the oldest streams that edit or drive each node or one below it. Empty: nobody takes nodes away
// from an older stream, and there is no need to know.
std::vector<uint64_t> EditBook::find_owners_below(const scene::Scene& scene, const PoseState& poses,
                                                  const Owners& editors) const {
  const uint64_t oldest = age_rank(std::min(streams_.begin()->first, poses.oldest_age()));
  const bool is_needed = std::any_of(streams_.begin(), streams_.end(), [&](const auto& entry) {
    const auto& edits = entry.second.edits;
    return age_rank(entry.first) != oldest && std::any_of(edits.begin(), edits.end(), [](const auto& edit) {
             return takes_away(edit.second.edit.value);
           });
  });
  if (!is_needed) return {};
  std::vector<uint64_t> owners(scene.nodes.size());
  for (uint32_t node = 0; node < owners.size(); ++node)
    owners[node] = poses.age_of_driver(node).value_or(UINT64_MAX);
  for (uint32_t node = 0; node < owners.size(); ++node) owners[node] = std::min(owners[node], editors[node]);
  for (size_t node = owners.size(); node-- > 0;) {  // children stand behind their parents
    const uint32_t parent = scene.nodes[node].parent;
    if (parent != scene::kNone) owners[parent] = std::min(owners[parent], owners[node]);
  }
  return owners;
}

// The oldest stream that edits or drives a node keeps it.
scene::NodeEdits EditBook::resolve(const scene::Scene& scene, const PoseState& poses, bool complete) {
  scene::NodeEdits result;
  vertex_nodes_.clear();
  vertex_budgets_.clear();
  if (streams_.empty()) return result;
  // Refused edits have no effect until their keys get other values.
  for (auto& [age, stream] : streams_)
    std::erase_if(stream.edits, [](const auto& edit) { return edit.second.refused; });
  bind(poses);
  const Owners editors = find_editors(scene.nodes.size());
  const std::vector<uint64_t> owners_below = find_owners_below(scene, poses, editors);
  for (auto& [age, stream] : streams_) {
    if (stream.id < poses.streams().size() && poses.streams()[stream.id].active)
      stream.name = poses.streams()[stream.id].name;
    for (auto& [key, kept] : stream.edits) {
      if (kept.refused) continue;
      const uint32_t node = kept.bound_node;
      if (node == scene::kNone) {
        // What is on its way may be found later, and what is not there need not be removed.
        if (complete && !kept.node && !std::holds_alternative<wire::NodeRemoved>(kept.edit.value))
          fault(stream, kept, &EditFaults::unmatched, "no scene node is called " + scene::quote(key.first));
        continue;
      }
      const auto is_older = [rank = age_rank(age)](uint64_t other) { return age_rank(other) < rank; };
      if (is_older(editors[node]) || is_older(poses.age_of_driver(node).value_or(UINT64_MAX))) {
        fault(stream, kept, &EditFaults::conflicting,
              "another stream has the node " + scene::quote(key.first));
        continue;
      }
      if (!owners_below.empty() && takes_away(kept.edit.value) && is_older(owners_below[node])) {
        fault(stream, kept, &EditFaults::conflicting,
              "an older stream has nodes below " + scene::quote(key.first));
        continue;
      }
      if (!kept.node) apply(scene, node, stream, kept, result[node]);  // an addition changes nothing further
    }
  }
  return result;
}

void EditBook::apply(const scene::Scene& scene, uint32_t node, StreamBook& stream, Kept& kept,
                     scene::NodeEdit& result) {
  const wire::EditValue& value = kept.edit.value;
  if (const auto* visible = std::get_if<wire::Visible>(&value)) {
    result.hidden = !visible->visible;
  } else if (const auto* color = std::get_if<wire::BaseColor>(&value)) {
    if (scene.nodes[node].mesh == scene::kNone) {
      fault(stream, kept, &EditFaults::unfit,
            "the node \"" + kept.edit.node + "\" has no mesh to be coloured");
      return;
    }
    result.base_color = glm::vec4(color->rgba[0], color->rgba[1], color->rgba[2], color->rgba[3]);
  } else if (const auto* light = std::get_if<wire::Light>(&value)) {
    scene::Light wanted = light_of(*light, scene, node);
    if (charge_light(scene, node, stream, kept, wanted)) result.light = wanted;
  } else if (const auto* camera = std::get_if<wire::Camera>(&value)) {
    result.camera = camera_of(*camera, scene, node);
  } else if (std::holds_alternative<wire::NodeRemoved>(value)) {
    result.removed = true;
  } else if (kept.vertices) {
    replace_vertices(scene, node, stream, kept, result);
  }
}

// A light beyond the limit is refused; one whose shadow is beyond its limit shines without a shadow. What the
// scene's own light at the node costs already is not charged.
bool EditBook::charge_light(const scene::Scene& scene, uint32_t node, StreamBook& stream, Kept& kept,
                            scene::Light& light) {
  if (!stream.budget) return true;
  const uint32_t own = scene.nodes[node].light;
  const bool has_light = own != scene::kNone;
  const bool has_shadow = has_light && scene.lights[own].casts_shadow && scene.lights[own].type == light.type;
  if (!std::exchange(kept.is_light_charged, true)) {
    const std::string name = "the light at the node " + scene::quote(kept.edit.node);
    Result<BudgetCharge> charge = BudgetCharge::take(stream.budget, Resource::lights, has_light ? 0 : 1);
    if (!charge) {
      kept.refused = true;
      fault(stream, kept, &EditFaults::refused, name + ": " + charge.error().message);
      return false;
    }
    kept.light = std::move(*charge);
    if (light.casts_shadow && !has_shadow) {
      Result<BudgetCharge> shadow = BudgetCharge::take(stream.budget, Resource::shadow_lights, 1);
      if (shadow) {
        kept.shadow_light = std::move(*shadow);
      } else if (!std::exchange(stream.reported_shadows, true)) {
        notes_.push_back(name + " of stream \"" + stream.name +
                         "\" casts no shadow: " + shadow.error().message);
      }
    }
  }
  light.casts_shadow = light.casts_shadow && (has_shadow || kept.shadow_light.amount() > 0);
  return true;
}

std::shared_ptr<PeerBudget> EditBook::vertex_budget(const std::string& node) const {
  const auto found = vertex_budgets_.find(node);
  return found == vertex_budgets_.end() ? nullptr : found->second;
}

void EditBook::replace_vertices(const scene::Scene& scene, uint32_t node, StreamBook& stream, Kept& kept,
                                scene::NodeEdit& result) {
  const std::string name = "the node " + scene::quote(kept.edit.node);
  if (!scene::takes_vertices(scene.nodes[node])) {
    fault(stream, kept, &EditFaults::unfit,
          scene.nodes[node].mesh == scene::kNone
              ? name + " has no mesh whose vertices could be replaced"
              : name + " has a skin or morph targets, which move its vertices");
    return;
  }
  const uint64_t count = scene::file_vertex_count(scene, scene.meshes[scene.nodes[node].mesh]);
  if (count != kept.vertices->positions.size()) {
    fault(stream, kept, &EditFaults::unfit,
          name + " has " + std::to_string(count) + " vertices, not " +
              std::to_string(kept.vertices->positions.size()));
    return;
  }
  vertex_nodes_.insert(kept.edit.node);
  vertex_budgets_[kept.edit.node] = stream.budget;
  result.vertices = kept.vertices;
  if (scene.nodes[node].own_vertices) {
    finish(stream, kept);
  } else if (made_for_.contains(kept.edit.node)) {
    const auto reason = vertex_refusals_.find(kept.edit.node);
    fault(stream, kept, &EditFaults::unfit,
          reason == vertex_refusals_.end() ? name + " has more vertices than there is room for"
                                           : name + ": " + reason->second);
  }
}

// The user hears of each cause once a stream; all of them are counted.
void EditBook::fault(StreamBook& stream, Kept& kept, uint64_t EditFaults::*cause, const std::string& reason) {
  if (!kept.node) finish(stream, kept);
  if (kept.fault_version == kept.edit.version) return;
  kept.fault_version = kept.edit.version;
  ++(faults_.*cause);
  if (std::find(stream.told.begin(), stream.told.end(), cause) != stream.told.end()) return;
  stream.told.push_back(cause);
  notes_.push_back("an edit of stream \"" + stream.name + "\" is without effect: " + reason);
}

}  // namespace fire3dv::state
