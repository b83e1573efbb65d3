#include "renderer/state/edit_book.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>

#include "renderer/scene/edits/replaced_vertices.h"
#include "renderer/scene/files.h"

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

void EditRegistry::take(std::vector<SceneChanges> changes, const NodeNames* file_names) {
  std::vector<std::string> added;
  for (SceneChanges& change : changes) {
    if (change.ended) {
      const auto stream = streams_.find(change.age);
      if (stream == streams_.end()) continue;
      if (change.may_return) {
        reserve(stream->second);
      } else {
        end(stream->second);
        streams_.erase(stream);
      }
      change_wanted(change.age);
      continue;
    }
    StreamRegistry& stream = streams_[change.age];
    stream.age = change.age;
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
void EditRegistry::reserve(StreamRegistry& stream) {
  std::vector<uint32_t>& nodes = stream.reserved_nodes;
  for (const auto& [key, kept] : stream.edits) {
    if (kept.bound_node != kNone) nodes.push_back(kept.bound_node);
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  nodes.shrink_to_fit();
  for (const uint32_t node : nodes) reserve_node(stream.age, node);
  for (auto& [key, kept] : stream.edits) {
    retire(kept);
    unlink(kept);
  }
  stream.edits.clear();
  stream.budget.reset();
}

void EditRegistry::end(StreamRegistry& stream) {
  for (auto& [key, kept] : stream.edits) {
    retire(kept);
    unlink(kept);
  }
  for (const uint32_t node : stream.reserved_nodes) release_node(stream.age, node);
}

// Its value is not in force any more.
void EditRegistry::retire(Kept& kept) {
  const std::pair version(kept.stream->age, kept.edit.version);
  for (Versions* versions : {&unsearched_, &unmatched_, &refused_}) versions->erase(version);
  if (std::exchange(kept.is_there, false)) unwanted_.push_back(version);
}

uint64_t EditRegistry::Editors::oldest() const {
  return std::min(edits.empty() ? UINT64_MAX : edits.front()->stream->age,
                  reserved.empty() ? UINT64_MAX : reserved.front());
}

template <typename Change>
void EditRegistry::change_editors(uint32_t node, const Change& change) {
  const auto editors = editors_.try_emplace(node).first;
  const uint64_t before = editors->second.oldest();
  change(editors->second);
  owners_changed_ |= age_rank(editors->second.oldest()) != age_rank(before);
  if (editors->second.oldest() == UINT64_MAX) editors_.erase(editors);
  dirty_.push_back(node);
}

void EditRegistry::link(Kept& kept, uint32_t node) {
  kept.bound_node = node;
  change_editors(node, [&](Editors& editors) {
    const auto is_before = [](const Kept* a, const Kept* b) {
      if (a->stream->age != b->stream->age) return a->stream->age < b->stream->age;
      const int names = a->edit.node.compare(b->edit.node);
      return names != 0 ? names < 0 : a->edit.property < b->edit.property;
    };
    editors.edits.insert(std::lower_bound(editors.edits.begin(), editors.edits.end(), &kept, is_before),
                         &kept);
  });
  count_taker(kept, 1);
}

void EditRegistry::unlink(Kept& kept) {
  if (kept.bound_node == kNone) return;
  count_taker(kept, -1);
  change_editors(kept.bound_node, [&](Editors& editors) { std::erase(editors.edits, &kept); });
  kept.bound_node = kNone;
}

void EditRegistry::reserve_node(uint64_t age, uint32_t node) {
  change_editors(node, [&](Editors& editors) {
    const auto place = std::lower_bound(editors.reserved.begin(), editors.reserved.end(), age);
    if (place == editors.reserved.end() || *place != age) editors.reserved.insert(place, age);
  });
}

void EditRegistry::release_node(uint64_t age, uint32_t node) {
  change_editors(node, [&](Editors& editors) { std::erase(editors.reserved, age); });
}

void EditRegistry::count_taker(const Kept& kept, int more) {
  if (!takes_away(kept.edit.value)) return;
  const auto count = [more](auto& counts, auto key) {
    const auto entry = counts.try_emplace(key, 0).first;
    entry->second += static_cast<uint32_t>(more);
    if (entry->second == 0) counts.erase(entry);
  };
  count(takers_, kept.bound_node);
  count(taker_ranks_, age_rank(kept.stream->age));
}

void EditRegistry::keep(StreamRegistry& stream, wire::SceneEdit&& edit, BudgetCharge charge) {
  const Key key(edit.node, edit.property);
  if (edit.property == wire::Property::node) change_wanted(stream.age);
  const auto known = stream.edits.find(key);
  if (known != stream.edits.end()) {
    finish(stream, known->second);  // nobody will see it any more
    retire(known->second);
  }
  if (std::holds_alternative<wire::Cleared>(edit.value)) {
    if (known == stream.edits.end()) return;
    unlink(known->second);
    stream.edits.erase(known);
    return;
  }
  Kept& kept = stream.edits[key];
  const uint32_t bound_node = kept.bound_node;
  const bool is_searched = kept.is_searched;
  if (bound_node != kNone) count_taker(kept, -1);
  kept = {};
  kept.stream = &stream;
  kept.bound_node = bound_node;
  kept.is_searched = is_searched;
  kept.charge = std::move(charge);
  kept.edit = std::move(edit);
  const std::pair version(stream.age, kept.edit.version);
  if (bound_node != kNone) {
    count_taker(kept, 1);
    dirty_.push_back(bound_node);
  } else {
    (is_searched ? unmatched_ : unsearched_).emplace(version, &kept);
  }
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
void EditRegistry::settle_name(const std::string& name, const NodeNames* file_names) {
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

void EditRegistry::finish(StreamRegistry& stream, Kept& kept) {
  if (std::exchange(kept.finished, true)) return;
  finished_.push_back({stream.id, kept.edit.epoch, kept.edit.version});
}

std::vector<WantedNode> EditRegistry::wanted_nodes() const {
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

EditRegistry::Kept* EditRegistry::find(const WantedNode& node) {
  const auto stream = streams_.find(node.age);
  if (stream == streams_.end()) return nullptr;
  const auto kept = stream->second.edits.find(Key(node.name, wire::Property::node));
  const bool same = kept != stream->second.edits.end() && kept->second.edit.version == node.version;
  return same ? &kept->second : nullptr;  // else another edit has taken its place meanwhile
}

bool EditRegistry::is_wanted(const WantedNode& node) const {
  const auto stream = streams_.find(node.age);
  if (stream == streams_.end()) return false;
  const auto kept = stream->second.edits.find(Key(node.name, wire::Property::node));
  return kept != stream->second.edits.end() && kept->second.edit.version == node.version &&
         kept->second.node && !kept->second.refused;
}

bool EditRegistry::node_is_there(const WantedNode& node) {
  Kept* const kept = find(node);
  if (!kept) return false;
  kept->is_there = kept->node && !kept->refused;
  finish(*kept->stream, *kept);
  return kept->is_there;
}

void EditRegistry::change_wanted(uint64_t age) {
  ++wanted_revision_;
  wanted_ages_.insert(age);
}

std::set<std::shared_ptr<PeerBudget>> EditRegistry::take_wanted_changes() {
  std::set<std::shared_ptr<PeerBudget>> peers;
  for (const uint64_t age : std::exchange(wanted_ages_, {})) {
    const auto stream = streams_.find(age);
    peers.insert(stream == streams_.end() ? nullptr : stream->second.budget);
  }
  return peers;
}

void EditRegistry::refuse_node(const WantedNode& node, const std::string& reason) {
  if (Kept* const kept = find(node)) refuse(*kept->stream, *kept, reason);
}

void EditRegistry::refuse(StreamRegistry& stream, Kept& kept, const std::string& reason) {
  constexpr uint32_t kMaxTold = 8;  // of one stream
  if (std::exchange(kept.refused, true)) return;
  refused_.emplace(std::pair(stream.age, kept.edit.version), &kept);
  if (std::exchange(kept.is_there, false)) unwanted_.emplace_back(stream.age, kept.edit.version);
  ++faults_.refused;
  change_wanted(stream.age);
  if (++stream.refusals_told <= kMaxTold)
    notes_.push_back("the node " + quote(kept.edit.node) + " of stream \"" + stream.name +
                     "\" is not added: " + reason +
                     (stream.refusals_told == kMaxTold ? "; further nodes are refused without a word" : ""));
  finish(stream, kept);
}

// Refused edits have no effect until their keys get other values.
void EditRegistry::erase_refused() {
  for (const auto& [version, kept] : Versions(std::move(refused_))) {
    StreamRegistry& stream = *kept->stream;
    const Key key(kept->edit.node, kept->edit.property);
    retire(*kept);
    unlink(*kept);
    stream.edits.erase(key);
  }
  refused_.clear();
}

void EditRegistry::search(Kept& kept, const PoseState& poses) {
  kept.is_searched = true;
  const uint32_t node = poses.names().find(kept.edit.node);
  if (node != kNone) return link(kept, node);
  unmatched_.emplace(std::pair(kept.stream->age, kept.edit.version), &kept);
}

// Edits stay with their nodes when the scene is replaced, whatever names the new one has.
void EditRegistry::bind_all(const PoseState& poses) {
  const bool is_next = poses.scene_revision() == scene_revision_ + 1;
  const std::vector<uint32_t>& new_node = poses.new_node_of_old();
  const auto follow = [&](uint32_t node) {
    return is_next && node < new_node.size() ? new_node[node] : kNone;
  };
  scene_revision_ = poses.scene_revision();
  driver_revision_ = poses.driver_revision();
  editors_.clear();
  dirty_.clear();
  unsearched_.clear();
  unmatched_.clear();
  takers_.clear();
  taker_ranks_.clear();
  owners_below_.clear();
  parents_.clear();
  node_edits_.clear();
  vertex_nodes_.clear();
  vertex_uses_of_node_.clear();
  vertex_budgets_.clear();
  owners_changed_ = true;
  resolved_ = {true, {}};
  for (auto& [age, stream] : streams_) {
    for (uint32_t& node : stream.reserved_nodes) node = follow(node);
    std::erase(stream.reserved_nodes, kNone);
    for (const uint32_t node : stream.reserved_nodes) reserve_node(age, node);
    for (auto& [key, kept] : stream.edits) {
      const uint32_t node = follow(std::exchange(kept.bound_node, kNone));
      if (node != kNone) {
        link(kept, node);
      } else {
        search(kept, poses);
      }
    }
  }
}

// Who moves a node decides whose edits of it count.
void EditRegistry::follow_drivers(const PoseState& poses) {
  const uint64_t before = std::exchange(driver_revision_, poses.driver_revision());
  if (before == driver_revision_) return;
  owners_changed_ = true;
  const std::optional<std::span<const uint32_t>> changed = poses.driver_changes_since(before);
  if (!changed) {
    for (const auto& [node, editors] : editors_) dirty_.push_back(node);
    return;
  }
  for (const uint32_t node : *changed) {
    if (editors_.contains(node)) dirty_.push_back(node);
  }
}

void EditRegistry::find_owners_below(const scene::Scene& scene, const PoseState& poses) {
  const uint64_t oldest = streams_.empty() ? 0 : std::min(streams_.begin()->first, poses.oldest_age());
  const bool is_needed = !taker_ranks_.empty() && taker_ranks_.rbegin()->first > age_rank(oldest);
  if (!is_needed) {
    for (const auto& [node, count] : takers_) {
      if (has_older_below(node)) dirty_.push_back(node);
    }
    owners_below_.clear();
    return;
  }
  if (!std::exchange(owners_changed_, false) && !owners_below_.empty()) return;
  if (parents_.empty()) {
    for (const scene::Node& node : scene.nodes) parents_.push_back(node.parent);
  }
  std::vector<uint64_t> owners(parents_.size());
  for (uint32_t node = 0; node < owners.size(); ++node)
    owners[node] = poses.age_of_driver(node).value_or(UINT64_MAX);
  for (const auto& [node, editors] : editors_) owners[node] = std::min(owners[node], editors.oldest());
  for (size_t node = owners.size(); node-- > 0;) {  // children stand behind their parents
    const uint32_t parent = parents_[node];
    if (parent != scene::kNone) owners[parent] = std::min(owners[parent], owners[node]);
  }
  std::swap(owners_below_, owners);
  for (const auto& [node, count] : takers_) {
    const bool same = !owners.empty() && age_rank(owners[node]) == age_rank(owners_below_[node]);
    if (!same && (!owners.empty() || has_older_below(node))) dirty_.push_back(node);
  }
}

// An older stream than those that edit the node has it, or one below it.
bool EditRegistry::has_older_below(uint32_t node) const {
  const auto editors = editors_.find(node);
  return !owners_below_.empty() && editors != editors_.end() &&
         age_rank(owners_below_[node]) < age_rank(editors->second.oldest());
}

// The oldest stream that edits or drives a node keeps it.
const scene::NodeEdits& EditRegistry::resolve(const scene::Scene& scene, const PoseState& poses,
                                              bool complete) {
  erase_refused();
  for (auto& [age, stream] : streams_) {
    if (stream.id < poses.streams().size() && poses.streams()[stream.id].active &&
        stream.name != poses.streams()[stream.id].name)
      stream.name = poses.streams()[stream.id].name;
  }
  if (poses.scene_revision() != scene_revision_) bind_all(poses);
  for (const auto& [version, kept] : std::exchange(unsearched_, {})) search(*kept, poses);
  follow_drivers(poses);
  find_owners_below(scene, poses);
  // In the order in which their edits came: limits of lights go to those that came first.
  std::set<uint32_t> done;
  for (const uint32_t node : dirty_) {
    if (done.insert(node).second) resolve_node(scene, poses, node);
  }
  dirty_.clear();
  if (complete) report_unmatched();
  return node_edits_;
}

EditRegistry::Resolved EditRegistry::take_resolved() {
  Resolved resolved = std::exchange(resolved_, {});
  std::sort(resolved.nodes.begin(), resolved.nodes.end());
  resolved.nodes.erase(std::unique(resolved.nodes.begin(), resolved.nodes.end()), resolved.nodes.end());
  if (resolved.all) resolved.nodes.clear();
  return resolved;
}

void EditRegistry::resolve_node(const scene::Scene& scene, const PoseState& poses, uint32_t node) {
  ++nodes_resolved_;
  if (!resolved_.all) resolved_.nodes.push_back(node);
  drop_vertex_uses(node);
  node_edits_.erase(node);
  const auto editors = editors_.find(node);
  if (editors == editors_.end()) return;
  const uint64_t owner = std::min(editors->second.oldest(), poses.age_of_driver(node).value_or(UINT64_MAX));
  for (Kept* const kept : editors->second.edits) {
    if (kept->refused) continue;
    StreamRegistry& stream = *kept->stream;
    const auto is_older = [rank = age_rank(stream.age)](uint64_t other) { return age_rank(other) < rank; };
    if (is_older(owner)) {
      fault(stream, *kept, &EditFaults::conflicting, "another stream has the node " + quote(kept->edit.node));
      continue;
    }
    if (!owners_below_.empty() && takes_away(kept->edit.value) && is_older(owners_below_[node])) {
      fault(stream, *kept, &EditFaults::conflicting,
            "an older stream has nodes below " + quote(kept->edit.node));
      continue;
    }
    // An addition changes nothing further.
    if (!kept->node) apply(scene, node, stream, *kept, node_edits_[node]);
  }
}

// What is on its way may be found later, and what is not there need not be removed.
void EditRegistry::report_unmatched() {
  for (const auto& [version, kept] : std::exchange(unmatched_, {})) {
    if (kept->node || std::holds_alternative<wire::NodeRemoved>(kept->edit.value)) continue;
    fault(*kept->stream, *kept, &EditFaults::unmatched, "no scene node is called " + quote(kept->edit.node));
  }
}

void EditRegistry::apply(const scene::Scene& scene, uint32_t node, StreamRegistry& stream, Kept& kept,
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
bool EditRegistry::charge_light(const scene::Scene& scene, uint32_t node, StreamRegistry& stream, Kept& kept,
                                scene::Light& light) {
  if (!stream.budget) return true;
  const uint32_t own = scene.nodes[node].light;
  const bool has_light = own != scene::kNone;
  const bool has_shadow = has_light && scene.lights[own].casts_shadow && scene.lights[own].type == light.type;
  if (!std::exchange(kept.is_light_charged, true)) {
    const std::string name = "the light at the node " + quote(kept.edit.node);
    Result<BudgetCharge> charge = BudgetCharge::take(stream.budget, Resource::lights, has_light ? 0 : 1);
    if (!charge) {
      kept.refused = true;
      refused_.emplace(std::pair(stream.age, kept.edit.version), &kept);
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

// Of several streams that use the name the youngest pays.
std::shared_ptr<PeerBudget> EditRegistry::vertex_budget(const std::string& node) const {
  const auto found = vertex_budgets_.find(node);
  return found == vertex_budgets_.end() ? nullptr : found->second.rbegin()->second;
}

void EditRegistry::scene_made_for(const std::vector<std::string>& vertex_nodes,
                                  std::map<std::string, std::string> reasons) {
  made_for_ = {vertex_nodes.begin(), vertex_nodes.end()};
  vertex_refusals_ = std::move(reasons);
  for (const auto& [node, uses] : vertex_uses_of_node_) dirty_.push_back(node);
}

void EditRegistry::drop_vertex_uses(uint32_t node) {
  const auto uses = vertex_uses_of_node_.find(node);
  if (uses == vertex_uses_of_node_.end()) return;
  for (const VertexUse& use : uses->second) {
    const auto budgets = vertex_budgets_.find(use.name);
    budgets->second.erase({use.age, node});
    if (!budgets->second.empty()) continue;
    vertex_budgets_.erase(budgets);
    vertex_nodes_.erase(use.name);
  }
  vertex_uses_of_node_.erase(uses);
}

void EditRegistry::replace_vertices(const scene::Scene& scene, uint32_t node, StreamRegistry& stream,
                                    Kept& kept, scene::NodeEdit& result) {
  const std::string name = "the node " + quote(kept.edit.node);
  if (!scene::can_replace_vertices(scene.nodes[node])) {
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
  vertex_budgets_[kept.edit.node][{stream.age, node}] = stream.budget;
  vertex_uses_of_node_[node].push_back({kept.edit.node, stream.age});
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
void EditRegistry::fault(StreamRegistry& stream, Kept& kept, uint64_t EditFaults::*cause,
                         const std::string& reason) {
  if (!kept.node) finish(stream, kept);
  if (kept.fault_version == kept.edit.version) return;
  kept.fault_version = kept.edit.version;
  ++(faults_.*cause);
  if (std::find(stream.told.begin(), stream.told.end(), cause) != stream.told.end()) return;
  stream.told.push_back(cause);
  notes_.push_back("an edit of stream \"" + stream.name + "\" is without effect: " + reason);
}

}  // namespace fire3dv::state
