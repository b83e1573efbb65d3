#include "renderer/passes/visibility/draw_list.h"

#include <algorithm>
#include <tuple>

namespace fire3dv::passes {

DrawList DrawList::collect(const scene::Scene& scene, const std::vector<bool>& mirrored,
                           const std::vector<bool>& hidden) {
  struct Candidate {
    Draw draw;
    scene::Topology topology;
    scene::AlphaMode alpha_mode;
    bool double_sided, inside_out;
    uint32_t material;
    auto key() const {
      return std::tuple(alpha_mode, topology, double_sided, inside_out, material, draw.primitive, draw.node);
    }
    bool same_bin(const DrawBin& bin) const {
      return topology == bin.topology && alpha_mode == bin.alpha_mode && double_sided == bin.double_sided &&
             inside_out == bin.mirrored;
    }
  };
  std::vector<Candidate> candidates;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    const scene::Node& node = scene.nodes[n];
    if (node.mesh == scene::kNone || (!hidden.empty() && hidden[n])) continue;
    const scene::Mesh& mesh = scene.meshes[node.mesh];
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
      const uint32_t material = scene.primitives[p].material;
      candidates.push_back({{n, p},
                            scene.primitives[p].topology,
                            scene::drawn_alpha_mode(scene.materials[material]),
                            scene.materials[material].double_sided,
                            mirrored[n],
                            material});
    }
  }
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.key() < b.key(); });

  DrawList list;
  for (const Candidate& c : candidates) {
    if (list.bins.empty() || !c.same_bin(list.bins.back())) {
      list.bins.push_back({c.topology, c.alpha_mode, c.double_sided, c.inside_out,
                           static_cast<uint32_t>(list.draws.size()), 0});
    }
    list.bins.back().draw_count++;
    list.draws.push_back(c.draw);
  }
  return list;
}

}  // namespace fire3dv::passes
