// What geoms of a compiled MuJoCo model look like: shapes, and materials as near as metal and roughness come
// to MuJoCo's specular lights.
#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <map>
#include <optional>

#include "tools/convert/model.h"

namespace fire3dv::convert {

class MjcfLooks {
 public:
  MjcfLooks(const mjModel& m, Model& model) : m_(m), model_(model) {}

  // As MuJoCo's viewer starts: the groups 0 to 2. Collision shapes are in 3 and higher, by custom.
  bool is_shown(int geom) const;
  // In the geom's frame.
  Surface shape(int geom) const;
  size_t material(int geom) { return material_of(m_.geom_matid[geom], rgba(geom)); }
  size_t tendon_material(int tendon);
  // As displayed, not linear.
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
