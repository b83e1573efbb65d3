#include "renderer/state/edit_book.h"

#include <algorithm>

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
      continue;
    }
    StreamBook& stream = streams_[change.age];
    stream.id = change.stream;
    for (wire::SceneEdit& edit : change.edits) {
      Key key(edit.node, edit.property);
      if (std::holds_alternative<wire::Cleared>(edit.value)) {
        stream.edits.erase(key);
      } else {
        stream.edits[std::move(key)].edit = std::move(edit);
      }
    }
  }
}

// Streams are asked by age: who comes first to a node keeps it, be it by edits or by poses.
scene::NodeEdits EditBook::resolve(const scene::Scene& scene, const PoseState& poses) {
  scene::NodeEdits result;
  std::map<uint32_t, uint64_t> editor;  // ages, of nodes
  for (auto& [age, stream] : streams_) {
    stream.name = poses.streams()[stream.id].name;
    for (auto& [key, kept] : stream.edits) {
      const uint32_t node = poses.names().find(key.first);
      if (node == scene::kNone) {
        fault(stream, kept, &EditFaults::unmatched, "no scene node is called \"" + key.first + "\"");
        continue;
      }
      const std::optional<uint64_t> driver = poses.age_of_driver(node);
      const uint64_t owner = editor.try_emplace(node, age).first->second;
      if (owner != age || (driver && *driver < age)) {
        fault(stream, kept, &EditFaults::conflicting, "another stream has the node \"" + key.first + "\"");
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
    result.light = light_of(*light, scene, node);
  } else if (const auto* camera = std::get_if<wire::Camera>(&value)) {
    result.camera = camera_of(*camera, scene, node);
  } else if (std::holds_alternative<wire::NodeRemoved>(value)) {
    result.removed = true;
  }
}

// The user hears of each cause once a stream; all of them are counted.
void EditBook::fault(StreamBook& stream, Kept& kept, uint64_t EditFaults::*cause, const std::string& reason) {
  if (kept.fault_version == kept.edit.version) return;
  kept.fault_version = kept.edit.version;
  ++(faults_.*cause);
  if (std::find(stream.told.begin(), stream.told.end(), cause) != stream.told.end()) return;
  stream.told.push_back(cause);
  notes_.push_back("an edit of stream \"" + stream.name + "\" is without effect: " + reason);
}

}  // namespace fire3dv::state
