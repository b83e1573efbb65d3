#include "renderer/passes/outputs/silhouettes.h"

namespace fire3dv::passes {

std::vector<uint32_t> nodes_with_silhouettes(const scene::Scene& scene) {
  std::vector<uint32_t> nodes;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n)
    if (scene.nodes[n].mesh != scene::kNone) nodes.push_back(n);
  return nodes;
}

std::vector<uint32_t> nodes_without_labels(const scene::Scene& scene, float label_alpha) {
  std::vector<uint32_t> nodes;
  for (const uint32_t node : nodes_with_silhouettes(scene)) {
    const scene::Mesh& mesh = scene.meshes[scene.nodes[node].mesh];
    bool has_triangles = false, has_labels = false;
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
      if (scene.primitives[p].topology != scene::Topology::triangles) continue;
      const scene::Material& material = scene.materials[scene.primitives[p].material];
      has_triangles = true;
      has_labels |= material.alpha_mode != scene::AlphaMode::blend || material.base_color.a > label_alpha;
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
