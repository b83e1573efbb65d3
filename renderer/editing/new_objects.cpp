#include "renderer/editing/new_objects.h"

#include <algorithm>
#include <glm/gtc/quaternion.hpp>
#include <utility>

#include "base/text.h"
#include "renderer/editing/document_additions.h"
#include "renderer/scene/derived/key_light.h"
#include "renderer/scene/derived/loaded_scene.h"

namespace fire3dv::app {
namespace {

std::string unused_name(const std::string& name, bool is_plain_allowed, const std::string& parent,
                        const state::EditDocument& document, const state::EditTargets& targets) {
  const auto is_taken = [&](const std::string& candidate) {
    const std::string path = (parent.empty() ? "" : parent + "/") + path_part(candidate);
    return targets.names.has(candidate) || targets.names.has(path) ||
           document.contains(state::key_of_addition(candidate));
  };
  if (is_plain_allowed && !name.empty() && !is_taken(name)) return name;
  return state::next_name(name.empty() ? "node" : name, is_taken);
}

state::NodeTransform at(const glm::vec3& position_m) {
  state::NodeTransform transform;
  transform.translation = position_m;
  return transform;
}

// Along the view, without the rounding of a matrix in its scale.
state::NodeTransform as_camera(const glm::mat4& world_from_camera, const glm::vec3& position_m) {
  state::NodeTransform transform = at(position_m);
  transform.rotation = glm::normalize(glm::quat_cast(glm::mat3(world_from_camera)));
  return transform;
}

scene::Light light_of(ObjectKind kind, float view_distance_m) {
  scene::Light light;
  if (kind == ObjectKind::directional_light) {
    light.type = scene::LightType::directional;
    light.intensity = scene::kKeyLightLux;
    return light;
  }
  light.type = kind == ObjectKind::spot_light ? scene::LightType::spot : scene::LightType::point;
  // As bright as the default light at a quarter of the view's distance.
  const float distance_m = std::max(view_distance_m / 4, 1e-3f);
  light.intensity = scene::kKeyLightLux * distance_m * distance_m;
  return light;
}

const char* name_of(ObjectKind kind) {
  switch (kind) {
    case ObjectKind::point_light:
      return "point light";
    case ObjectKind::spot_light:
      return "spot light";
    case ObjectKind::directional_light:
      return "directional light";
    case ObjectKind::camera:
      break;
  }
  return "camera";
}

// Relative to the parent, as shown: that of a stream that drives the node, else the user's, else that of a
// stream above it, of joints or animations, else that of the file, exactly.
state::NodeTransform transform_now(uint32_t node, const EditorView& view, const state::EditDocument& document,
                                   const state::EditKey& key, const scene::Scene& scene) {
  const scene::Node& now = scene.nodes[node];
  const bool is_posed = view.poses && view.poses->world_from_node(node) != now.world_from_node;
  const bool is_driven = view.poses && direct_driver_of(*view.poses, node);
  const auto edited = document.find(key);
  if (edited != document.end() && !is_driven) return std::get<state::NodeTransform>(edited->second);
  if (is_posed) {
    const glm::mat4 world_from_parent =
        now.parent == scene::kNone ? glm::mat4(1) : view.poses->world_from_node(now.parent);
    return state::to_transform(glm::inverse(world_from_parent) * view.poses->world_from_node(node));
  }
  if (now.given_by_matrix) return state::to_transform(now.parent_from_node);
  state::NodeTransform transform = at(now.translation);
  transform.rotation = now.rotation;
  transform.scale = now.scale;
  return transform;
}

}  // namespace

NewObject new_object(ObjectKind kind, const EditorView& view, const state::EditDocument& document,
                     const state::EditTargets& targets) {
  NewObject object{unused_name(name_of(kind), true, {}, document, targets), {}};
  const glm::vec3 eye_m(view.world_from_camera[3]);
  if (kind == ObjectKind::camera) {
    scene::Camera camera = view.camera;
    camera.name.clear();
    camera.aspect = 0;
    object.addition.content = camera;
    object.addition.transform = as_camera(view.world_from_camera, eye_m);
    return object;
  }
  object.addition.content = light_of(kind, glm::length(view.focus_m - eye_m));
  object.addition.transform =
      kind == ObjectKind::point_light ? at(view.focus_m) : as_camera(view.world_from_camera, view.focus_m);
  return object;
}

NewObject new_asset(const std::string& uri, const EditorView& view, const state::EditDocument& document,
                    const state::EditTargets& targets) {
  NewObject object{unused_name(name_of_asset(uri), true, {}, document, targets), {}};
  object.addition.content = state::AddedAsset{uri};
  object.addition.transform = at(view.focus_m);
  return object;
}

bool may_add_camera(const state::EditDocument& document, const std::string& name) {
  const auto added = document.find(state::key_of_addition(name));
  if (added == document.end()) return false;
  const auto& content = std::get<state::Addition>(added->second).content;
  return std::holds_alternative<scene::Camera>(content) || std::holds_alternative<state::CopiedNode>(content);
}

Result<size_t> find_added_camera(const std::string& name, const scene::Scene& scene,
                                 std::span<const ShownAddition> shown) {
  const std::vector<uint32_t> nodes = scene::camera_nodes(scene);
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (scene.nodes[nodes[i]].name == name) return i;
  }
  const bool is_shown = std::ranges::find(shown, name, &ShownAddition::name) != shown.end();
  return Error{"--camera " + name + ": the node that the overlay file adds " +
               (is_shown ? "has no camera" : "is not displayed: a warning above says why")};
}

Result<NewObject> duplicate(uint32_t number, const EditorView& view, const state::EditDocument& document,
                            const state::EditTargets& targets) {
  const scene::Scene& scene = targets.scene;
  FIRE3DV_ASSERT(number < scene.nodes.size());
  const scene::Node& node = scene.nodes[number];
  const std::string parent = node.parent == scene::kNone ? std::string() : scene.nodes[node.parent].path;
  if (node.path.empty())
    return Error{parent.empty() ? "it has no name; give it one in the scene file"
                                : "it is an instance of " + quote(parent) + "; copy that node"};
  if (targets.names.find(node.path) != number ||
      (node.parent != scene::kNone && targets.names.find(parent) != node.parent))
    return Error{"several nodes are called " + quote(node.path) + " or its parent; give them other names"};
  state::Additions additions;
  for (const auto& [key, value] : document) {
    if (const auto* const addition = std::get_if<state::Addition>(&value)) additions[key.name] = *addition;
  }
  NewObject copy;
  copy.addition.parent = parent;
  copy.addition.content = state::CopiedNode{node.path};
  const std::string added = state::addition_at(additions, node.path);
  if (!added.empty()) copy.addition.content = additions.at(added).content;
  // The last part of the path, where a node of an asset has no name.
  const std::string last = node.path.substr(node.path.rfind('/') + 1);
  copy.name = unused_name(node.name.empty() ? last : node.name, false, parent, document, targets);
  copy.addition.transform =
      transform_now(number, view, document,
                    {state::EditedObject::node, node.path, 0, state::EditedProperty::transform}, scene);
  if (!state::is_valid(copy.addition.transform)) return Error{quote(node.path) + " has no size"};
  copy.edits = state::edits_of_copy(document, node.path, state::path_of(copy.name, copy.addition));
  if (std::holds_alternative<state::AddedAsset>(copy.addition.content))
    copy.edits.merge(state::material_edits_of_copy(document, added, copy.name));
  return copy;
}

}  // namespace fire3dv::app
