#include "renderer/passes/outputs/silhouettes.h"

#include "renderer/scene/model/scene_edits.h"

namespace fire3dv::passes {

std::vector<uint32_t> nodes_with_silhouettes(const scene::Scene& scene) {
  std::vector<uint32_t> nodes;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n)
    if (scene.nodes[n].mesh != scene::kNone) nodes.push_back(n);
  return nodes;
}

float largest_alpha(const scene::Scene& scene, const scene::SceneEdits* edits, uint32_t node,
                    const scene::Primitive& primitive) {
  if (edits) {
    const auto of_node = edits->nodes().find(node);
    if (of_node != edits->nodes().end() && of_node->second.base_color) return of_node->second.base_color->a;
    const auto of_material = edits->materials().find(primitive.material);
    if (of_material != edits->materials().end()) return of_material->second.base_color.a;
  }
  return scene.materials[primitive.material].base_color.a;
}

std::vector<uint32_t> nodes_without_labels(const scene::Scene& scene, const scene::SceneEdits* edits,
                                           float label_alpha) {
  std::vector<uint32_t> nodes;
  for (const uint32_t node : nodes_with_silhouettes(scene)) {
    if (edits && edits->is_hidden(node)) continue;
    const scene::Mesh& mesh = scene.meshes[scene.nodes[node].mesh];
    bool has_triangles = false, has_labels = false;
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
      if (scene.primitives[p].topology != scene::Topology::triangles) continue;
      const scene::Primitive& primitive = scene.primitives[p];
      has_triangles = true;
      has_labels |= scene.materials[primitive.material].alpha_mode != scene::AlphaMode::blend ||
                    largest_alpha(scene, edits, node, primitive) > label_alpha;
    }
    if (has_triangles && !has_labels) nodes.push_back(node);
  }
  return nodes;
}

uint64_t silhouette_bytes(uint32_t slots, uint32_t width, uint32_t height) {
  return sizeof(uint32_t) * uint64_t{silhouette_words(slots)} * (uint64_t{width} * height + 1);
}

void add_silhouettes(std::vector<PlaneRange>& places, uint32_t slots, uint32_t width, uint32_t height) {
  constexpr uint64_t kAlignment = 64;
  const uint64_t offset = (bytes_of(places) + kAlignment - 1) / kAlignment * kAlignment;
  places.push_back({wire::kAmodal, offset, silhouette_bytes(slots, width, height)});
}

}  // namespace fire3dv::passes
