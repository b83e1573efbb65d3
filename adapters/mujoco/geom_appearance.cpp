#include "adapters/mujoco/geom_appearance.h"

#include "tools/convert/mesh/colors.h"
#include "tools/convert/mjcf/mjcf_names.h"

namespace fire3dv::mujoco {
namespace {

std::array<float, 4> color_of(const mjModel& m, size_t geom) {
  return convert::mjcf_color(m, m.geom_matid[geom], m.geom_rgba + 4 * geom);
}

bool is_shown(const mjModel& m, size_t geom, const std::array<float, 4>& rgba) {
  return convert::is_shown_group(m.geom_group[geom]) && rgba[3] > 0;
}

}  // namespace

GeomAppearance::GeomAppearance(const mjModel& m) : appearances_(static_cast<size_t>(m.ngeom)) {
  for (size_t i = 0; i < appearances_.size(); ++i) {
    Appearance& appearance = appearances_[i];
    appearance.rgba = color_of(m, i);
    appearance.is_shown = appearance.is_in_scene = is_shown(m, i, appearance.rgba);
  }
}

const std::vector<GeomEdit>& GeomAppearance::changes(const mjModel& m) {
  changes_.clear();
  for (size_t i = 0; i < appearances_.size(); ++i) {
    Appearance& appearance = appearances_[i];
    if (!appearance.is_in_scene) continue;
    const std::array<float, 4> rgba = color_of(m, i);
    const bool shown = is_shown(m, i, rgba);
    if (rgba == appearance.rgba && shown == appearance.is_shown) continue;
    GeomEdit edit{i, {}, {}};
    if (shown != appearance.is_shown) edit.visible = shown;
    if (rgba != appearance.rgba && shown) {
      const glm::vec4 linear = convert::linear_from_srgb(glm::vec4(rgba[0], rgba[1], rgba[2], rgba[3]));
      edit.rgba = {linear.r, linear.g, linear.b, linear.a};
      appearance.rgba = rgba;
    }
    appearance.is_shown = shown;
    changes_.push_back(edit);
  }
  return changes_;
}

}  // namespace fire3dv::mujoco
