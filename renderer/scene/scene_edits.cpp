#include "renderer/scene/scene_edits.h"

#include <algorithm>

namespace fire3dv::scene {
namespace {

// Whether one part of all edits differs. Both maps are walked side by side, since most nodes have none.
template <typename Part>
bool differs(const NodeEdits& before, const NodeEdits& after, const Part& part) {
  const NodeEdit nothing;
  auto a = before.begin(), b = after.begin();
  while (a != before.end() || b != after.end()) {
    const bool take_a = a != before.end() && (b == after.end() || a->first <= b->first);
    const bool take_b = b != after.end() && (a == before.end() || b->first <= a->first);
    if (part(take_a ? a->second : nothing) != part(take_b ? b->second : nothing)) return true;
    if (take_a) ++a;
    if (take_b) ++b;
  }
  return false;
}

// Parents stand before their children. Empty: none is.
template <typename Is>
std::vector<bool> with_all_below(const Scene& scene, const NodeEdits& edits, const Is& is) {
  if (std::none_of(edits.begin(), edits.end(), [&](const auto& entry) { return is(entry.second); }))
    return {};
  std::vector<bool> marked(scene.nodes.size(), false);
  for (const auto& [node, edit] : edits) {
    if (node < marked.size() && is(edit)) marked[node] = true;
  }
  for (uint32_t node = 0; node < marked.size(); ++node) {
    const uint32_t parent = scene.nodes[node].parent;
    if (parent != kNone && marked[parent]) marked[node] = true;
  }
  return marked;
}

void hide_all_but(const Scene& scene, uint32_t isolated, std::vector<bool>& hidden) {
  hidden.resize(scene.nodes.size(), false);
  std::vector<bool> shown(scene.nodes.size(), false);
  for (uint32_t node = 0; node < shown.size(); ++node) {
    const uint32_t parent = scene.nodes[node].parent;
    shown[node] = node == isolated || (parent != kNone && shown[parent]);
    if (!shown[node]) hidden[node] = true;
  }
}

}  // namespace

void SceneEdits::set(const Scene& scene, NodeEdits edits, uint32_t isolated) {
  std::vector<bool> hidden =
      with_all_below(scene, edits, [](const NodeEdit& e) { return e.hidden || e.removed; });
  if (isolated < scene.nodes.size()) hide_all_but(scene, isolated, hidden);
  std::vector<bool> removed = with_all_below(scene, edits, [](const NodeEdit& e) { return e.removed; });
  if (hidden != hidden_) ++revisions_.visible;
  if (differs(nodes_, edits, [](const NodeEdit& e) { return e.base_color; })) ++revisions_.base_color;
  if (removed != removed_ || differs(nodes_, edits, [](const NodeEdit& e) { return e.light; }))
    ++revisions_.light;
  if (differs(nodes_, edits, [](const NodeEdit& e) { return e.camera; })) ++revisions_.camera;
  if (differs(nodes_, edits, [](const NodeEdit& e) { return e.vertices; })) ++revisions_.vertices;
  hidden_ = std::move(hidden);
  removed_ = std::move(removed);
  nodes_ = std::move(edits);
}

void SceneEdits::set_materials(MaterialEdits edits) {
  if (edits == materials_) return;
  materials_ = std::move(edits);
  ++revisions_.materials;
}

MaterialFactors factors_of(const Material& material) {
  return {material.base_color,   material.emissive,           material.metallic,    material.roughness,
          material.normal_scale, material.occlusion_strength, material.alpha_cutoff};
}

Material with_factors(Material material, const MaterialFactors& factors) {
  material.base_color = factors.base_color;
  material.emissive = factors.emissive;
  material.metallic = factors.metallic;
  material.roughness = factors.roughness;
  material.normal_scale = factors.normal_scale;
  material.occlusion_strength = factors.occlusion_strength;
  material.alpha_cutoff = factors.alpha_cutoff;
  return material;
}

const Camera* SceneEdits::camera_at(uint32_t node) const {
  const auto edit = nodes_.find(node);
  return edit != nodes_.end() && edit->second.camera ? &*edit->second.camera : nullptr;
}

std::vector<PlacedLight> lights_of(const Scene& scene, const SceneEdits* edits) {
  std::vector<PlacedLight> lights;
  static const NodeEdits kNoEdits;
  const NodeEdits& edited = edits ? edits->nodes() : kNoEdits;
  auto edit = edited.begin();
  for (uint32_t node = 0; node < scene.nodes.size(); ++node) {
    while (edit != edited.end() && edit->first < node) ++edit;
    if (edits && edits->is_removed(node)) continue;
    if (edit != edited.end() && edit->first == node && edit->second.light) {
      lights.push_back({*edit->second.light, node});
    } else if (scene.nodes[node].light != kNone) {
      lights.push_back({scene.lights[scene.nodes[node].light], node});
    }
  }
  return lights;
}

}  // namespace fire3dv::scene
