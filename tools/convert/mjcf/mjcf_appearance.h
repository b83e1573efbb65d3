// Appearance of geoms in a compiled MuJoCo model: meshes, and metallic-roughness materials that approximate
// MuJoCo's specular shading.
#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <map>
#include <optional>

#include "tools/convert/model.h"

namespace fire3dv::convert {

class MjcfAppearance {
 public:
  MjcfAppearance(const mjModel& m, Model& model) : m_(m), model_(model) {}

  // Shows groups 0 to 2, as MuJoCo's viewer does at start. By convention, collision geoms are in groups 3 and
  // higher.
  bool is_shown(int geom) const;
  // In the geom's frame.
  Surface shape(int geom) const;
  size_t material(int geom) { return material_of(m_.geom_matid[geom], rgba(geom)); }
  size_t tendon_material(int tendon);
  // Displayed colour (sRGB).
  std::array<float, 4> rgba(int geom) const;

 private:
  size_t material_of(int index, const std::array<float, 4>& color);
  std::optional<size_t> image(int material_index);
  glm::dvec2 plane_repeats(int geom, const glm::dvec2& half) const;

  const mjModel& m_;
  Model& model_;
  std::map<std::pair<int, std::array<float, 4>>, size_t> materials_;
  std::map<int, std::optional<size_t>> images_;
};

}  // namespace fire3dv::convert
