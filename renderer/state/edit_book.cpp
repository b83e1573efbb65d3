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

}  // namespace

void EditBook::take(std::vector<SceneChanges> changes) {
  for (SceneChanges& change : changes) {
    if (change.ended) {
      streams_.erase(change.age);
      ++wanted_revision_;
      continue;
    }
    StreamBook& stream = streams_[change.age];
    stream.id = change.stream;
    stream.budget = change.budget;
    for (wire::SceneEdit& edit : change.edits) keep(stream, std::move(edit));
  }
}

void EditBook::keep(StreamBook& stream, wire::SceneEdit&& edit) {
  const Key key(edit.node, edit.property);
  if (edit.property == wire::Property::node) ++wanted_revision_;
  const auto known = stream.edits.find(key);
  if (known != stream.edits.end()) finish(stream, known->second);  // nobody will see it any more
  if (std::holds_alternative<wire::Cleared>(edit.value)) {
    if (known != stream.edits.end()) stream.edits.erase(known);
    return;
  }
  Kept& kept = stream.edits[key] = {};
  kept.edit = std::move(edit);
  if (auto* node = std::get_if<wire::NodeAdded>(&kept.edit.value)) {
    kept.node = std::make_shared<const wire::NodeAdded>(std::move(*node));
    kept.finished = false;
  } else if (auto* vertices = std::get_if<wire::Vertices>(&kept.edit.value)) {
    auto replaced = std::make_shared<scene::ReplacedVertices>();
    for (const auto& p : vertices->positions) replaced->positions.emplace_back(p[0], p[1], p[2]);
    for (const auto& n : vertices->normals) replaced->normals.emplace_back(n[0], n[1], n[2]);
    *vertices = {};
    kept.vertices = std::move(replaced);
    kept.finished = false;
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

void EditBook::node_is_there(const WantedNode& node) {
  if (Kept* const kept = find(node)) finish(streams_[node.age], *kept);
}

void EditBook::refuse_node(const WantedNode& node, const std::string& reason) {
  Kept* const kept = find(node);
  if (!kept || std::exchange(kept->refused, true)) return;
  ++faults_.refused;
  ++wanted_revision_;
  notes_.push_back("the node " + scene::quote(node.name) + " of stream \"" + streams_[node.age].name +
                   "\" is not added: " + reason);
  finish(streams_[node.age], *kept);
}

// Streams are asked by age: who comes first to a node keeps it, be it by edits or by poses.
scene::NodeEdits EditBook::resolve(const scene::Scene& scene, const PoseState& poses, bool complete) {
  scene::NodeEdits result;
  vertex_nodes_.clear();
  vertex_budgets_.clear();
  std::map<uint32_t, uint64_t> editor;  // ages, of nodes
  for (auto& [age, stream] : streams_) {
    stream.name = poses.streams()[stream.id].name;
    for (auto& [key, kept] : stream.edits) {
      const uint32_t node = poses.names().find(key.first);
      if (node == scene::kNone) {
        // What is on its way may be found later, and what is not there need not be removed.
        if (complete && !kept.node && !std::holds_alternative<wire::NodeRemoved>(kept.edit.value))
          fault(stream, kept, &EditFaults::unmatched, "no scene node is called " + scene::quote(key.first));
        continue;
      }
      const std::optional<uint64_t> driver = poses.age_of_driver(node);
      const uint64_t owner = editor.try_emplace(node, age).first->second;
      if (owner != age || (driver && *driver < age)) {
        fault(stream, kept, &EditFaults::conflicting,
              "another stream has the node " + scene::quote(key.first));
        continue;
      }
      apply(scene, node, stream, kept, result[node]);
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
    if (charge_light(stream, kept, wanted)) result.light = wanted;
  } else if (const auto* camera = std::get_if<wire::Camera>(&value)) {
    result.camera = camera_of(*camera, scene, node);
  } else if (std::holds_alternative<wire::NodeRemoved>(value)) {
    result.removed = true;
  } else if (kept.vertices) {
    replace_vertices(scene, node, stream, kept, result);
  }
}

// A light beyond the limit is refused; one whose shadow is beyond its limit shines without a shadow.
bool EditBook::charge_light(StreamBook& stream, Kept& kept, scene::Light& light) {
  if (!stream.budget) return true;
  if (kept.refused) return false;
  if (kept.light.amount() == 0) {
    Result<BudgetCharge> charge = BudgetCharge::take(stream.budget, Resource::lights, 1);
    if (!charge) {
      kept.refused = true;
      fault(stream, kept, &EditFaults::refused,
            "the light at the node " + scene::quote(kept.edit.node) + ": " + charge.error().message);
      return false;
    }
    kept.light = std::move(*charge);
    if (light.casts_shadow) {
      Result<BudgetCharge> shadow = BudgetCharge::take(stream.budget, Resource::shadow_lights, 1);
      if (shadow) {
        kept.shadow_light = std::move(*shadow);
      } else if (!std::exchange(stream.reported_shadows, true)) {
        notes_.push_back("the light at the node " + scene::quote(kept.edit.node) + " of stream \"" +
                         stream.name + "\" casts no shadow: " + shadow.error().message);
      }
    }
  }
  light.casts_shadow &= kept.shadow_light.amount() > 0;
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
