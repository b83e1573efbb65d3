#include "adapters/mujoco/compare/labels.h"

#include <string>
#include <unordered_map>

namespace fire3dv::mujoco {

std::vector<uint32_t> endless_planes(const mjModel& model) {
  std::vector<uint32_t> found;
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const mjtNum* size = model.geom_size + 3 * geom;
    if (model.geom_type[geom] == mjGEOM_PLANE && (size[0] <= 0 || size[1] <= 0))
      found.push_back(label_of(mjOBJ_GEOM, geom));
  }
  return found;
}

InstanceLabels::InstanceLabels(const mjModel& model, const scene::Scene& scene) {
  const convert::MjcfNames names(model);
  std::unordered_map<std::string, uint32_t> by_name;
  for (size_t i = 0; i < names.geoms.size(); ++i)
    by_name[names.geoms[i]] = label_of(mjOBJ_GEOM, static_cast<int>(i));
  for (size_t i = 0; i < names.tendon_pieces.size(); ++i) {
    for (const auto* pieces : {&names.tendon_pieces[i], &names.tendon_ends[i]})
      for (const std::string& piece : *pieces) by_name[piece] = label_of(mjOBJ_TENDON, static_cast<int>(i));
  }
  labels_.assign(scene.nodes.size() + 1, kNoLabel);
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    const auto found = by_name.find(scene.nodes[i].name);
    if (found != by_name.end()) labels_[i + 1] = found->second;
  }
}

}  // namespace fire3dv::mujoco
