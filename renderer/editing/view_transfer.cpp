#include "renderer/editing/view_transfer.h"

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

bool refers_to_scene(const gui::ViewState& viewer) {
  for (const uint32_t node :
       {viewer.selected, viewer.followed, viewer.edits.isolated, viewer.edits.variant}) {
    if (node != scene::kNone) return true;
  }
  return viewer.picked_point || !viewer.measured.empty() || !viewer.edits.hidden.empty() ||
         !viewer.edits.removed.empty() || !viewer.edits.lights.empty() || !viewer.edits.materials.empty() ||
         !viewer.edits.transforms.empty();
}

void transfer_by_key(gui::ViewState& viewer, const state::EditTargets& from, const state::EditTargets& to) {
  const scene::Scene &before = from.scene, &after = to.scene;
  ObjectsByKey objects(from, to);
  const auto moved = [&](uint32_t node) { return objects.node(node); };
  for (uint32_t* node : {&viewer.selected, &viewer.followed, &viewer.edits.isolated}) *node = moved(*node);
  const auto is_lost = [&](gui::SurfacePoint& point) {
    if (point.node == scene::kNone) return false;
    point.node = moved(point.node);
    return point.node == scene::kNone;
  };
  if (viewer.picked_point && is_lost(*viewer.picked_point)) viewer.picked_point.reset();
  std::erase_if(viewer.measured, is_lost);
  for (std::set<uint32_t>* nodes : {&viewer.edits.hidden, &viewer.edits.removed}) {
    for (const uint32_t node : std::exchange(*nodes, {})) {
      if (const uint32_t now = moved(node); now != scene::kNone) nodes->insert(now);
    }
  }
  std::map<uint32_t, scene::Light> lights;
  for (auto& [node, light] : viewer.edits.lights) {
    const uint32_t now = moved(node);
    if (now != scene::kNone && light_type(before, {}, node) == light_type(after, {}, now))
      lights.emplace(now, std::move(light));
  }
  viewer.edits.lights = std::move(lights);
  for (auto& [number, material] : std::exchange(viewer.edits.materials, {})) {
    if (number >= before.materials.size()) continue;
    const uint32_t now = objects.find(state::EditedObject::material, number, state::EditedProperty::factors);
    if (now != scene::kNone) viewer.edits.materials.emplace(now, std::move(material));
  }
  viewer.edits.variant = scene::variant_of_same_name(viewer.edits.variant, before, after);
  state::NodeTransforms transforms;
  for (const auto& [node, transform] : viewer.edits.transforms) {
    if (const uint32_t now = moved(node); now != scene::kNone) transforms.emplace(now, transform);
  }
  viewer.edits.transforms = std::move(transforms);
}

void forget_scene(gui::ViewState& viewer) {
  viewer.selected = viewer.followed = scene::kNone;
  viewer.picked_point.reset();
  viewer.measured.clear();
  state::UserEdits edits;
  edits.hidden_markers = std::move(viewer.edits.hidden_markers);
  viewer.edits = std::move(edits);
  viewer.streams.clear();
  viewer.commands = {};
}

}  // namespace fire3dv::app
