// Names, visibility and tendons of a compiled model.
#include <algorithm>

#include "adapters/mujoco/compiled/compiled_scene.h"

namespace fire3dv::convert {
namespace {

constexpr int kPulley = -2;  // marker in mjData::wrap_obj: the path restarts behind it

glm::dvec3 to_vec3(const mjtNum* v) {
  return {v[0], v[1], v[2]};
}

}  // namespace

MjcfNames names_of(const mjModel& m) {
  MjcfOwnNames own;
  const auto take = [&](int count, const int* addresses, std::vector<std::string>& to) {
    for (int i = 0; i < count; ++i) to.emplace_back(m.names + addresses[i]);
  };
  take(m.nbody, m.name_bodyadr, own.bodies);
  take(m.ncam, m.name_camadr, own.cameras);
  take(m.nlight, m.name_lightadr, own.lights);
  take(m.ngeom, m.name_geomadr, own.geoms);
  for (int i = 0; i < m.ntendon; ++i)
    own.tendons.emplace_back(m.names + m.name_tendonadr[i], max_tendon_points(m, i));
  return MjcfNames(own);
}

std::array<float, 4> compiled_color(const mjModel& m, int material, const float* own) {
  const std::array<float, 4> color{own[0], own[1], own[2], own[3]};
  if (material < 0) return color;
  const float* rgba = m.mat_rgba + 4 * material;
  const std::array<float, 4> of_material{rgba[0], rgba[1], rgba[2], rgba[3]};
  return mjcf_color(color, &of_material);
}

bool is_scene_light(const mjModel& m, int light) {
  const mjtNum* direction = m.light_dir + 3 * light;
  const float* diffuse = m.light_diffuse + 3 * light;
  const bool shines_somewhere = mju_norm3(direction) > 0;
  return m.light_active[light] && shines_somewhere &&
         std::any_of(diffuse, diffuse + 3, [](float c) { return c > 0; });
}

size_t max_tendon_points(const mjModel& m, int tendon) {
  const float opacity = compiled_color(m, m.tendon_matid[tendon], m.tendon_rgba + 4 * tendon)[3];
  if (!is_shown_group(m.tendon_group[tendon]) || !(opacity > 0) || !(m.tendon_width[tendon] > 0)) return 0;
  size_t points = 0;
  for (int i = m.tendon_adr[tendon]; i < m.tendon_adr[tendon] + m.tendon_num[tendon]; ++i) {
    if (m.wrap_type[i] == mjWRAP_SITE) points += 1;
    if (m.wrap_type[i] == mjWRAP_SPHERE || m.wrap_type[i] == mjWRAP_CYLINDER) points += 2;
  }
  return points < 2 ? 0 : points;
}

void tendon_pieces(const mjModel& m, const mjData& d, int tendon, std::vector<TendonPiece>& pieces) {
  pieces.clear();
  const int first = d.ten_wrapadr[tendon], end = first + d.ten_wrapnum[tendon];
  for (int i = first; i + 1 < end; ++i) {
    if (d.wrap_obj[i] == kPulley || d.wrap_obj[i + 1] == kPulley) continue;
    const bool lies_on_geom = d.wrap_obj[i] >= 0 && d.wrap_obj[i + 1] >= 0;
    pieces.push_back({to_vec3(d.wrap_xpos + 3 * i), to_vec3(d.wrap_xpos + 3 * (i + 1)),
                      m.tendon_width[tendon] * (lies_on_geom ? 0.5 : 1)});
  }
}

}  // namespace fire3dv::convert
