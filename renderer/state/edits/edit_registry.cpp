#include "renderer/state/edits/edit_registry.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>

#include "base/log.h"
#include "renderer/scene/files.h"
#include "renderer/state/edits/edit_values.h"

namespace fire3dv::state {

void EditRegistry::apply(std::vector<SceneChanges> changes, const NodeNames* file_names) {
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
      requests_changed(change.age);
      continue;
    }
    StreamEntry& stream = streams_[change.age];
    stream.age = change.age;
    stream.id = change.stream;
    stream.budget = change.budget;
    for (size_t i = 0; i < change.edits.size(); ++i) {
      wire::SceneEdit& edit = change.edits[i];
      if (std::holds_alternative<wire::NodeAdded>(edit.value)) added.push_back(edit.node);
      store(stream, std::move(edit),
            i < change.charges.size() ? std::move(change.charges[i]) : BudgetCharge());
    }
  }
  for (const std::string& name : added) resolve_name_conflict(name, file_names);
}

// Ends the edits of a suspended stream and reserves its nodes.
void EditRegistry::reserve(StreamEntry& stream) {
  std::vector<uint32_t>& nodes = stream.reserved_nodes;
  for (const auto& [key, entry] : stream.edits) {
    if (entry.bound_node != kNone) nodes.push_back(entry.bound_node);
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  nodes.shrink_to_fit();
  for (const uint32_t node : nodes) reserve_node(stream.age, node);
  for (auto& [key, entry] : stream.edits) {
    retire(entry);
    unlink(entry);
  }
  stream.edits.clear();
  stream.budget.reset();
}

void EditRegistry::end(StreamEntry& stream) {
  for (auto& [key, entry] : stream.edits) {
    retire(entry);
    unlink(entry);
  }
  for (const uint32_t node : stream.reserved_nodes) release_node(stream.age, node);
}

// The value is no longer in force.
void EditRegistry::retire(EditInForce& entry) {
  const std::pair version(entry.stream->age, entry.edit.version);
  for (Versions* versions : {&unbound_, &unmatched_, &refused_}) versions->erase(version);
  if (std::exchange(entry.is_added, false)) withdrawn_nodes_.push_back(version);
  if (const uint64_t replaced = std::exchange(entry.replaced_version, 0); replaced != 0)
    withdrawn_nodes_.emplace_back(entry.stream->age, replaced);
  end_wait_for_build(entry);
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

void EditRegistry::link(EditInForce& entry, uint32_t node) {
  entry.bound_node = node;
  change_editors(node, [&](Editors& editors) {
    const auto is_before = [](const EditInForce* a, const EditInForce* b) {
      if (a->stream->age != b->stream->age) return a->stream->age < b->stream->age;
      const int names = a->edit.node.compare(b->edit.node);
      return names != 0 ? names < 0 : a->edit.property < b->edit.property;
    };
    editors.edits.insert(std::lower_bound(editors.edits.begin(), editors.edits.end(), &entry, is_before),
                         &entry);
  });
  count_hiding(entry, 1);
}

void EditRegistry::unlink(EditInForce& entry) {
  if (entry.bound_node == kNone) return;
  count_hiding(entry, -1);
  change_editors(entry.bound_node, [&](Editors& editors) { std::erase(editors.edits, &entry); });
  entry.bound_node = kNone;
}

void EditRegistry::reserve_node(uint64_t age, uint32_t node) {
  change_editors(node, [&](Editors& editors) {
    const auto position = std::lower_bound(editors.reserved.begin(), editors.reserved.end(), age);
    if (position == editors.reserved.end() || *position != age) editors.reserved.insert(position, age);
  });
}

void EditRegistry::release_node(uint64_t age, uint32_t node) {
  change_editors(node, [&](Editors& editors) { std::erase(editors.reserved, age); });
}

void EditRegistry::count_hiding(const EditInForce& entry, int more) {
  if (!hides_subtree(entry.edit.value)) return;
  const auto count = [more](auto& counts, auto key) {
    const auto number = counts.try_emplace(key, 0).first;
    number->second += static_cast<uint32_t>(more);
    if (number->second == 0) counts.erase(number);
  };
  count(hiding_edits_, entry.bound_node);
  count(hiding_ranks_, age_rank(entry.stream->age));
}

void EditRegistry::store(StreamEntry& stream, wire::SceneEdit&& edit, BudgetCharge charge) {
  if (edit.property == wire::Property::marker) return;  // of no node; see MarkerRegistry
  const Key key(edit.node, edit.property);
  if (edit.property == wire::Property::node) requests_changed(stream.age);
  const auto known = stream.edits.find(key);
  uint64_t replaced_version = 0;
  if (known != stream.edits.end()) {
    // An added node that another one replaces stays until that is built: no image is without both.
    if (std::holds_alternative<wire::NodeAdded>(edit.value)) {
      replaced_version = std::exchange(known->second.replaced_version, 0);
      if (std::exchange(known->second.is_added, false)) replaced_version = known->second.edit.version;
    }
    finish(stream, known->second);  // replaced before it came into effect
    retire(known->second);
  }
  if (std::holds_alternative<wire::Cleared>(edit.value)) {
    if (known == stream.edits.end()) return;
    unlink(known->second);
    stream.edits.erase(known);
    return;
  }
  EditInForce& entry = stream.edits[key];
  const uint32_t bound_node = entry.bound_node;
  const bool is_looked_up = entry.is_looked_up;
  if (bound_node != kNone) count_hiding(entry, -1);
  auto before = entry.is_shown ? std::move(entry.vertices) : std::move(entry.before);
  BudgetCharge before_charge = entry.is_shown ? std::move(entry.charge) : std::move(entry.before_charge);
  entry = {};
  entry.stream = &stream;
  entry.before = std::move(before);
  entry.before_charge = std::move(before_charge);
  entry.replaced_version = replaced_version;
  entry.bound_node = bound_node;
  entry.is_looked_up = is_looked_up;
  entry.charge = std::move(charge);
  entry.edit = std::move(edit);
  const std::pair version(stream.age, entry.edit.version);
  if (bound_node != kNone) {
    count_hiding(entry, 1);
    dirty_.push_back(bound_node);
  } else {
    (is_looked_up ? unmatched_ : unbound_).emplace(version, &entry);
  }
  if (auto* node = std::get_if<wire::NodeAdded>(&entry.edit.value)) {
    entry.node = std::make_shared<const wire::NodeAdded>(std::move(*node));
    entry.finished = false;
    entry.awaits_build = true;
    ++stream.builds_awaited;
  } else if (auto* vertices = std::get_if<wire::Vertices>(&entry.edit.value)) {
    auto replaced = std::make_shared<scene::ReplacedVertices>();
    replaced->positions.reserve(vertices->positions.size());
    replaced->normals.reserve(vertices->normals.size());
    for (const auto& p : vertices->positions) replaced->positions.emplace_back(p[0], p[1], p[2]);
    for (const auto& n : vertices->normals) replaced->normals.emplace_back(n[0], n[1], n[2]);
    *vertices = {};
    entry.vertices = std::move(replaced);
    entry.finished = false;
  }
}

// The oldest stream that adds a name wins; names of the file are refused.
void EditRegistry::resolve_name_conflict(const std::string& name, const NodeNames* file_names) {
  const Key key(name, wire::Property::node);
  const bool in_file = file_names && file_names->file_has(name);
  bool taken = in_file;
  for (auto& [age, stream] : streams_) {
    const auto entry = stream.edits.find(key);
    if (entry == stream.edits.end() || !entry->second.node || entry->second.refused) continue;
    if (taken)
      refuse(stream, entry->second,
             in_file ? "the scene's file has that name already" : "an older stream adds a node of that name");
    taken = true;
  }
}

// After the last build that a stream waits for, its vertices fit their meshes, or are of no use.
void EditRegistry::end_wait_for_build(EditInForce& entry) {
  StreamEntry& stream = *entry.stream;
  if (!std::exchange(entry.awaits_build, false) || --stream.builds_awaited > 0) return;
  for (const uint32_t node : std::exchange(stream.waiting_vertices, {})) dirty_.push_back(node);
}

void EditRegistry::finish(StreamEntry& stream, EditInForce& entry) {
  end_wait_for_build(entry);
  if (std::exchange(entry.finished, true)) return;
  finished_.push_back({stream.id, entry.edit.epoch, entry.edit.version});
}

std::vector<RequestedNode> EditRegistry::requested_nodes() const {
  std::vector<RequestedNode> requested;
  for (const auto& [age, stream] : streams_) {
    const auto first = static_cast<std::ptrdiff_t>(requested.size());
    for (const auto& [key, entry] : stream.edits) {
      if (entry.node && !entry.refused)
        requested.push_back({age, entry.edit.version, key.first, entry.node, stream.budget});
    }
    std::sort(requested.begin() + first, requested.end(),
              [](const RequestedNode& a, const RequestedNode& b) { return a.version < b.version; });
  }
  return requested;
}

EditRegistry::EditInForce* EditRegistry::find(const RequestedNode& node) {
  const auto stream = streams_.find(node.age);
  if (stream == streams_.end()) return nullptr;
  const auto entry = stream->second.edits.find(Key(node.name, wire::Property::node));
  const bool same = entry != stream->second.edits.end() && entry->second.edit.version == node.version;
  return same ? &entry->second : nullptr;  // else a newer edit has replaced it
}

bool EditRegistry::is_requested(const RequestedNode& node) const {
  const auto stream = streams_.find(node.age);
  if (stream == streams_.end()) return false;
  const auto entry = stream->second.edits.find(Key(node.name, wire::Property::node));
  return entry != stream->second.edits.end() && entry->second.edit.version == node.version &&
         entry->second.node && !entry->second.refused;
}

bool EditRegistry::confirm_node(const RequestedNode& node) {
  EditInForce* const entry = find(node);
  if (!entry) return false;
  entry->is_added = entry->node && !entry->refused;
  entry->replaced_version = 0;  // this scene has it no more
  finish(*entry->stream, *entry);
  return entry->is_added;
}

bool EditRegistry::is_being_replaced(const RequestedNode& node) const {
  const auto stream = streams_.find(node.age);
  if (stream == streams_.end()) return false;
  const auto entry = stream->second.edits.find(Key(node.name, wire::Property::node));
  return entry != stream->second.edits.end() && entry->second.replaced_version == node.version;
}

void EditRegistry::requests_changed(uint64_t age) {
  ++requested_revision_;
  changed_ages_.insert(age);
}

std::set<std::shared_ptr<PeerBudget>> EditRegistry::take_changed_budgets() {
  std::set<std::shared_ptr<PeerBudget>> peers;
  for (const uint64_t age : std::exchange(changed_ages_, {})) {
    const auto stream = streams_.find(age);
    peers.insert(stream == streams_.end() ? nullptr : stream->second.budget);
  }
  return peers;
}

void EditRegistry::refuse_node(const RequestedNode& node, const std::string& reason) {
  if (EditInForce* const entry = find(node)) refuse(*entry->stream, *entry, reason);
}

void EditRegistry::refuse(StreamEntry& stream, EditInForce& entry, const std::string& reason) {
  constexpr uint32_t kMaxReported = 8;  // per stream
  if (std::exchange(entry.refused, true)) return;
  refused_.emplace(std::pair(stream.age, entry.edit.version), &entry);
  if (std::exchange(entry.is_added, false)) withdrawn_nodes_.emplace_back(stream.age, entry.edit.version);
  if (const uint64_t replaced = std::exchange(entry.replaced_version, 0); replaced != 0)
    withdrawn_nodes_.emplace_back(stream.age, replaced);
  ++faults_.refused;
  requests_changed(stream.age);
  report_to_stream(stream, "the node " + quote(entry.edit.node) + " is not added: " + reason);
  if (++stream.refusals_reported <= kMaxReported)
    log_messages_.push_back(warning(
        "the node " + quote(entry.edit.node) + " of stream \"" + stream.name + "\" is not added: " + reason +
        (stream.refusals_reported == kMaxReported ? "; further refusals are not logged" : "")));
  finish(stream, entry);
}

// Refused edits have no effect; a new value of the key is tried again.
void EditRegistry::erase_refused() {
  for (const auto& [version, entry] : Versions(std::move(refused_))) {
    StreamEntry& stream = *entry->stream;
    const Key key(entry->edit.node, entry->edit.property);
    retire(*entry);
    unlink(*entry);
    stream.edits.erase(key);
  }
  refused_.clear();
}

void EditRegistry::look_up(EditInForce& entry, const PoseState& poses) {
  entry.is_looked_up = true;
  const uint32_t node = poses.names().find(entry.edit.node);
  if (node != kNone) return link(entry, node);
  unmatched_.emplace(std::pair(entry.stream->age, entry.edit.version), &entry);
}

// Edits stay with their nodes when the scene is replaced, even if names in the new scene are ambiguous.
void EditRegistry::rebind_all(const PoseState& poses) {
  const bool is_next = poses.scene_revision() == scene_revision_ + 1;
  const std::vector<uint32_t>& new_node = poses.new_node_of_old();
  const auto new_node_of = [&](uint32_t node) {
    return is_next && node < new_node.size() ? new_node[node] : kNone;
  };
  scene_revision_ = poses.scene_revision();
  driver_revision_ = poses.driver_revision();
  editors_.clear();
  dirty_.clear();
  unbound_.clear();
  unmatched_.clear();
  hiding_edits_.clear();
  hiding_ranks_.clear();
  owners_below_.clear();
  parents_.clear();
  node_edits_.clear();
  vertex_uses_.clear();
  owners_changed_ = true;
  resolved_ = {true, {}};
  for (auto& [age, stream] : streams_) {
    stream.waiting_vertices.clear();
    for (uint32_t& node : stream.reserved_nodes) node = new_node_of(node);
    std::erase(stream.reserved_nodes, kNone);
    for (const uint32_t node : stream.reserved_nodes) reserve_node(age, node);
    for (auto& [key, entry] : stream.edits) {
      const uint32_t node = new_node_of(std::exchange(entry.bound_node, kNone));
      if (node != kNone) {
        link(entry, node);
      } else {
        look_up(entry, poses);
      }
    }
  }
}

// The driver of a node may be its owner, so changed drivers make edited nodes dirty.
void EditRegistry::mark_driver_changes(const PoseState& poses) {
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

void EditRegistry::update_owners_below(const scene::Scene& scene, const PoseState& poses) {
  const uint64_t oldest = streams_.empty() ? 0 : std::min(streams_.begin()->first, poses.oldest_age());
  const bool is_needed = !hiding_ranks_.empty() && hiding_ranks_.rbegin()->first > age_rank(oldest);
  if (!is_needed) {
    for (const auto& [node, count] : hiding_edits_) {
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
  for (size_t node = owners.size(); node-- > 0;) {  // children follow their parents
    const uint32_t parent = parents_[node];
    if (parent != scene::kNone) owners[parent] = std::min(owners[parent], owners[node]);
  }
  std::swap(owners_below_, owners);
  for (const auto& [node, count] : hiding_edits_) {
    const bool same = !owners.empty() && age_rank(owners[node]) == age_rank(owners_below_[node]);
    if (!same && (!owners.empty() || has_older_below(node))) dirty_.push_back(node);
  }
}

// True if a stream older than all editors of the node owns it or a node below it.
bool EditRegistry::has_older_below(uint32_t node) const {
  const auto editors = editors_.find(node);
  return !owners_below_.empty() && editors != editors_.end() &&
         age_rank(owners_below_[node]) < age_rank(editors->second.oldest());
}

const scene::NodeEdits& EditRegistry::resolve(const scene::Scene& scene, const PoseState& poses,
                                              bool complete) {
  erase_refused();
  for (auto& [age, stream] : streams_) {
    if (stream.id < poses.streams().size() && poses.streams()[stream.id].active &&
        stream.name != poses.streams()[stream.id].name)
      stream.name = poses.streams()[stream.id].name;
  }
  if (poses.scene_revision() != scene_revision_) rebind_all(poses);
  for (const auto& [version, entry] : std::exchange(unbound_, {})) look_up(*entry, poses);
  mark_driver_changes(poses);
  update_owners_below(scene, poses);
  // In order of arrival: the first lights get the limited light budget.
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
  vertex_uses_.remove(node);
  node_edits_.erase(node);
  const auto editors = editors_.find(node);
  if (editors == editors_.end()) return;
  const uint64_t owner = std::min(editors->second.oldest(), poses.age_of_driver(node).value_or(UINT64_MAX));
  for (EditInForce* const entry : editors->second.edits) {
    if (entry->refused) continue;
    StreamEntry& stream = *entry->stream;
    const auto is_older = [rank = age_rank(stream.age)](uint64_t other) { return age_rank(other) < rank; };
    if (is_older(owner)) {
      fault(stream, *entry, &EditFaults::conflicting,
            "another stream has the node " + quote(entry->edit.node));
      continue;
    }
    if (!owners_below_.empty() && hides_subtree(entry->edit.value) && is_older(owners_below_[node])) {
      fault(stream, *entry, &EditFaults::conflicting,
            "an older stream has nodes below " + quote(entry->edit.node));
      continue;
    }
    // Added nodes change the scene, not the edits of the node.
    if (!entry->node) apply_to_node(scene, node, stream, *entry, node_edits_[node]);
  }
}

// Additions bind later, and the removal of a missing node is no fault.
void EditRegistry::report_unmatched() {
  for (const auto& [version, entry] : std::exchange(unmatched_, {})) {
    if (entry->node || std::holds_alternative<wire::NodeRemoved>(entry->edit.value)) continue;
    fault(*entry->stream, *entry, &EditFaults::unmatched,
          "no scene node is called " + quote(entry->edit.node));
  }
}

void EditRegistry::apply_to_node(const scene::Scene& scene, uint32_t node, StreamEntry& stream,
                                 EditInForce& entry, scene::NodeEdit& result) {
  const wire::EditValue& value = entry.edit.value;
  if (const auto* visible = std::get_if<wire::Visible>(&value)) {
    result.hidden = !visible->visible;
  } else if (const auto* color = std::get_if<wire::BaseColor>(&value)) {
    if (scene.nodes[node].mesh == scene::kNone) {
      fault(stream, entry, &EditFaults::unfit,
            "the node \"" + entry.edit.node + "\" has no mesh to be coloured");
      return;
    }
    result.base_color = glm::vec4(color->rgba[0], color->rgba[1], color->rgba[2], color->rgba[3]);
    if (color->rgba[3] < 1) report_opaque(scene, node, stream, entry.edit.node);
  } else if (const auto* light = std::get_if<wire::Light>(&value)) {
    scene::Light requested = to_scene_light(*light, scene, node);
    if (charge_light(scene, node, stream, entry, requested)) result.light = requested;
  } else if (const auto* camera = std::get_if<wire::Camera>(&value)) {
    result.camera = to_scene_camera(*camera, scene, node);
  } else if (std::holds_alternative<wire::NodeRemoved>(value)) {
    result.removed = true;
  } else if (entry.vertices) {
    replace_vertices(scene, node, stream, entry, result);
  }
}

// Alpha has no effect on opaque materials. Logged once for each node, for the first nodes of a stream.
void EditRegistry::report_opaque(const scene::Scene& scene, uint32_t node, StreamEntry& stream,
                                 const std::string& name) {
  constexpr size_t kMaxReportedNodes = 16;
  if (stream.reported_opaque.size() == kMaxReportedNodes || stream.reported_opaque.contains(name)) return;
  const scene::Mesh& mesh = scene.meshes[scene.nodes[node].mesh];
  const auto primitives = std::span(scene.primitives).subspan(mesh.first_primitive, mesh.primitive_count);
  const bool is_opaque = std::ranges::all_of(primitives, [&](const scene::Primitive& primitive) {
    return scene::drawn_alpha_mode(scene.materials[primitive.material]) == scene::AlphaMode::opaque;
  });
  if (primitives.empty() || !is_opaque) return;
  stream.reported_opaque.insert(name);
  constexpr const char* kReason =
      " stays opaque: the alpha mode of its material is OPAQUE; export the material with alpha mode BLEND, "
      "or "
      "hide the node";
  report_to_stream(stream, "the node " + quote(name) + kReason);
  log_messages_.push_back(
      warning("the node " + quote(name) + " of stream \"" + stream.name + "\"" + kReason));
}

// Charges a light to the budget. A light over the limit is refused; one over the limit of shadows loses its
// shadow. The cost of the file's light at the node is not charged again.
bool EditRegistry::charge_light(const scene::Scene& scene, uint32_t node, StreamEntry& stream,
                                EditInForce& entry, scene::Light& light) {
  if (!stream.budget) return true;
  const uint32_t own = scene.nodes[node].light;
  const bool has_light = own != scene::kNone;
  const bool has_shadow = has_light && scene.lights[own].casts_shadow && scene.lights[own].type == light.type;
  if (!std::exchange(entry.is_light_charged, true)) {
    const std::string name = "the light at the node " + quote(entry.edit.node);
    Result<BudgetCharge> charge = BudgetCharge::take(stream.budget, Resource::lights, has_light ? 0 : 1);
    if (!charge) {
      entry.refused = true;
      refused_.emplace(std::pair(stream.age, entry.edit.version), &entry);
      fault(stream, entry, &EditFaults::refused, name + ": " + charge.error().message);
      return false;
    }
    entry.light = std::move(*charge);
    if (light.casts_shadow && !has_shadow) {
      Result<BudgetCharge> shadow = BudgetCharge::take(stream.budget, Resource::shadow_lights, 1);
      if (shadow) {
        entry.shadow_light = std::move(*shadow);
      } else if (!std::exchange(stream.reported_shadows, true)) {
        log_messages_.push_back(
            warning(name + " of stream \"" + stream.name + "\" casts no shadow: " + shadow.error().message));
      }
    }
  }
  light.casts_shadow = light.casts_shadow && (has_shadow || entry.shadow_light.amount() > 0);
  return true;
}

void EditRegistry::set_built_vertex_nodes(const std::vector<std::string>& vertex_nodes,
                                          std::map<std::string, std::string> reasons) {
  vertex_uses_.set_built(vertex_nodes, std::move(reasons));
  for (const uint32_t node : vertex_uses_.nodes()) dirty_.push_back(node);
}

void EditRegistry::replace_vertices(const scene::Scene& scene, uint32_t node, StreamEntry& stream,
                                    EditInForce& entry, scene::NodeEdit& result) {
  const std::string name = "the node " + quote(entry.edit.node);
  if (!scene::can_replace_vertices(scene.nodes[node])) {
    fault(stream, entry, &EditFaults::unfit,
          scene.nodes[node].mesh == scene::kNone
              ? name + " has no mesh whose vertices could be replaced"
              : name + " has a skin or morph targets, which move its vertices");
    return;
  }
  const uint64_t count = scene::file_vertex_count(scene, scene.meshes[scene.nodes[node].mesh]);
  if (count != entry.vertices->positions.size()) {
    if (!entry.finished && stream.builds_awaited > 0) {  // the mesh that they fit may be on its way
      stream.waiting_vertices.insert(node);
      if (!entry.before || entry.before->positions.size() != count) return;
      vertex_uses_.add(node, entry.edit.node, stream.age, stream.budget);
      result.vertices = entry.before;
      return;
    }
    fault(stream, entry, &EditFaults::unfit,
          name + " has " + std::to_string(count) + " vertices, not " +
              std::to_string(entry.vertices->positions.size()));
    return;
  }
  vertex_uses_.add(node, entry.edit.node, stream.age, stream.budget);
  result.vertices = entry.vertices;
  if (scene.nodes[node].has_instance_vertices) {
    entry.is_shown = true;
    entry.before.reset();
    entry.before_charge = {};
    finish(stream, entry);
  } else if (vertex_uses_.is_built(entry.edit.node)) {
    const std::string* const reason = vertex_uses_.refusal(entry.edit.node);
    fault(stream, entry, &EditFaults::unfit,
          reason ? name + ": " + *reason : name + " has more vertices than there is room for");
  }
}

// Bounded by streams and in all: nobody may take them.
void EditRegistry::report_to_stream(StreamEntry& stream, const std::string& reason) {
  constexpr uint32_t kMaxReported = 8;
  constexpr size_t kMaxWaiting = 1024;
  if (stream.ineffective_reported == kMaxReported || ineffective_.size() == kMaxWaiting) return;
  ++stream.ineffective_reported;
  ineffective_.push_back({stream.id, reason});
}

// Logs each cause once per stream; counts all.
void EditRegistry::fault(StreamEntry& stream, EditInForce& entry, uint64_t EditFaults::*cause,
                         const std::string& reason) {
  if (!entry.node) finish(stream, entry);
  if (entry.fault_version == entry.edit.version) return;
  entry.fault_version = entry.edit.version;
  ++(faults_.*cause);
  report_to_stream(stream, reason);
  if (std::find(stream.reported_causes.begin(), stream.reported_causes.end(), cause) !=
      stream.reported_causes.end())
    return;
  stream.reported_causes.push_back(cause);
  log_messages_.push_back(warning("an edit of stream \"" + stream.name + "\" is without effect: " + reason));
}

}  // namespace fire3dv::state
