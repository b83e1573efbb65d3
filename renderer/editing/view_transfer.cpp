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

bool refers_to_scene(const ViewState& view_state) {
  for (const uint32_t node :
       {view_state.selected, view_state.followed, view_state.edits.isolated, view_state.edits.variant}) {
    if (node != scene::kNone) return true;
  }
  return view_state.picked_point || !view_state.measured.empty() || !view_state.edits.hidden.empty() ||
         !view_state.edits.removed.empty() || !view_state.edits.lights.empty() ||
         !view_state.edits.materials.empty() || !view_state.edits.transforms.empty();
}

void transfer_by_key(ViewState& view_state, const state::EditTargets& from, const state::EditTargets& to) {
  const scene::Scene &before = from.scene, &after = to.scene;
  ObjectsByKey objects(from, to);
  const auto moved = [&](uint32_t node) { return objects.node(node); };
  for (uint32_t* node : {&view_state.selected, &view_state.followed, &view_state.edits.isolated})
    *node = moved(*node);
  const auto is_lost = [&](SurfacePoint& point) {
    if (point.node == scene::kNone) return false;
    point.node = moved(point.node);
    return point.node == scene::kNone;
  };
  if (view_state.picked_point && is_lost(*view_state.picked_point)) view_state.picked_point.reset();
  std::erase_if(view_state.measured, is_lost);
  for (std::set<uint32_t>* nodes : {&view_state.edits.hidden, &view_state.edits.removed}) {
    for (const uint32_t node : std::exchange(*nodes, {})) {
      if (const uint32_t now = moved(node); now != scene::kNone) nodes->insert(now);
    }
  }
  std::map<uint32_t, scene::Light> lights;
  for (auto& [node, light] : view_state.edits.lights) {
    const uint32_t now = moved(node);
    if (now != scene::kNone && light_type(before, {}, node) == light_type(after, {}, now))
      lights.emplace(now, std::move(light));
  }
  view_state.edits.lights = std::move(lights);
  for (auto& [number, material] : std::exchange(view_state.edits.materials, {})) {
    if (number >= before.materials.size()) continue;
    const uint32_t now = objects.find(state::EditedObject::material, number, state::EditedProperty::factors);
    if (now != scene::kNone) view_state.edits.materials.emplace(now, std::move(material));
  }
  view_state.edits.variant = scene::variant_of_same_name(view_state.edits.variant, before, after);
  state::NodeTransforms transforms;
  for (const auto& [node, transform] : view_state.edits.transforms) {
    if (const uint32_t now = moved(node); now != scene::kNone) transforms.emplace(now, transform);
  }
  view_state.edits.transforms = std::move(transforms);
}

void forget_scene(ViewState& view_state) {
  view_state.selected = view_state.followed = scene::kNone;
  view_state.picked_point.reset();
  view_state.measured.clear();
  state::UserEdits edits;
  edits.hidden_markers = std::move(view_state.edits.hidden_markers);
  view_state.edits = std::move(edits);
  view_state.streams.clear();
  view_state.commands = {};
}

}  // namespace fire3dv::app
