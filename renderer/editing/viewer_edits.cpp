#include "renderer/editing/viewer_edits.h"

#include <utility>

#include "renderer/editing/target_index.h"
#include "renderer/live_scene/live_scene.h"
#include "renderer/scene/derived/variants.h"

namespace fire3dv::app {

namespace {

// Maps numbers of objects of one scene to another.
class ObjectsByKey {
 public:
  ObjectsByKey(const state::EditTargets& before, const state::EditTargets& after)
      : before_(before), after_(after), count_(before.scene.nodes.size()) {}

  uint32_t node(uint32_t number) {
    return number < count_ ? find(state::EditedObject::node, number, state::EditedProperty::visible) : kNone;
  }
  uint32_t find(state::EditedObject object, uint32_t number, state::EditedProperty property) {
    return after_.find(before_.key_of(object, number, property));
  }

 private:
  static constexpr uint32_t kNone = scene::kNone;
  state::TargetIndex before_, after_;
  const size_t count_;  // of nodes
};

}  // namespace

bool refers_to_scene(const gui::Viewer& viewer) {
  for (const uint32_t node : {viewer.selected, viewer.followed, viewer.isolated, viewer.variant}) {
    if (node != scene::kNone) return true;
  }
  return viewer.picked_point || !viewer.measured.empty() || !viewer.hidden.empty() ||
         !viewer.removed.empty() || !viewer.lights.empty() || !viewer.materials.empty() ||
         !viewer.transforms.empty();
}

void transfer_by_key(gui::Viewer& viewer, const state::EditTargets& from, const state::EditTargets& to) {
  const scene::Scene &before = from.scene, &after = to.scene;
  ObjectsByKey objects(from, to);
  const auto moved = [&](uint32_t node) { return objects.node(node); };
  for (uint32_t* node : {&viewer.selected, &viewer.followed, &viewer.isolated}) *node = moved(*node);
  const auto is_lost = [&](gui::SurfacePoint& point) {
    if (point.node == scene::kNone) return false;
    point.node = moved(point.node);
    return point.node == scene::kNone;
  };
  if (viewer.picked_point && is_lost(*viewer.picked_point)) viewer.picked_point.reset();
  std::erase_if(viewer.measured, is_lost);
  for (std::set<uint32_t>* nodes : {&viewer.hidden, &viewer.removed}) {
    for (const uint32_t node : std::exchange(*nodes, {})) {
      if (const uint32_t now = moved(node); now != scene::kNone) nodes->insert(now);
    }
  }
  std::map<uint32_t, scene::Light> lights;
  for (auto& [node, light] : viewer.lights) {
    const uint32_t now = moved(node);
    if (now != scene::kNone && light_type(before, {}, node) == light_type(after, {}, now))
      lights.emplace(now, std::move(light));
  }
  viewer.lights = std::move(lights);
  for (auto& [number, material] : std::exchange(viewer.materials, {})) {
    if (number >= before.materials.size()) continue;
    const uint32_t now = objects.find(state::EditedObject::material, number, state::EditedProperty::factors);
    if (now != scene::kNone) viewer.materials.emplace(now, std::move(material));
  }
  viewer.variant = scene::variant_of_same_name(viewer.variant, before, after);
  state::NodeTransforms transforms;
  for (const auto& [node, transform] : viewer.transforms) {
    if (const uint32_t now = moved(node); now != scene::kNone) transforms.emplace(now, transform);
  }
  viewer.transforms = std::move(transforms);
}

void forget_scene(gui::Viewer& viewer) {
  viewer.selected = viewer.followed = viewer.isolated = scene::kNone;
  viewer.hidden.clear();
  viewer.picked_point.reset();
  viewer.measured.clear();
  viewer.removed.clear();
  viewer.lights.clear();
  viewer.materials.clear();
  viewer.transforms.clear();
  viewer.joints.clear();
  viewer.variant = scene::kNone;
  viewer.additions.clear();
  viewer.streams.clear();
  viewer.commands = {};
}

state::UserEdits edits_of(const gui::Viewer& viewer) {
  state::UserEdits edits{viewer.hidden,         viewer.isolated,   viewer.lights, {},
                         viewer.hidden_markers, viewer.transforms, viewer.joints, viewer.removed,
                         viewer.variant,        viewer.additions};
  for (const auto& [number, material] : viewer.materials)
    edits.materials.emplace(number, scene::factors_of(material));
  return edits;
}

}  // namespace fire3dv::app
