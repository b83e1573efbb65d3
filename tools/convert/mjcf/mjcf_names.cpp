#include "tools/convert/mjcf/mjcf_names.h"

#include <algorithm>
#include <set>

#include "tools/convert/mjcf/mjcf_tendons.h"

namespace fire3dv::convert {
namespace {

constexpr int kShownGroups = 3;

// Replaces control characters, which SPEC.md forbids in node names and which break message lines.
std::string printable(std::string name) {
  for (char& c : name)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return name;
}

class Names {
 public:
  explicit Names(const mjModel& m) : m_(m) {}

  // own: address in the model's name table.
  std::string free(int own, const std::string& kind, int index) {
    std::string name = printable(m_.names + own);
    if (name.empty()) name = kind + "_" + std::to_string(index);
    return free(std::move(name), kind);
  }

  std::string free(std::string name, const std::string& kind) {
    if (taken_.insert(name).second) return name;
    for (int i = 0;; ++i) {
      std::string other = name + " " + kind + (i ? " " + std::to_string(i) : "");
      if (taken_.insert(other).second) return other;
    }
  }

 private:
  const mjModel& m_;
  std::set<std::string> taken_;
};

}  // namespace

MjcfNames::MjcfNames(const mjModel& m)
    : bodies(static_cast<size_t>(m.nbody)),
      tendon_pieces(static_cast<size_t>(m.ntendon)),
      tendon_ends(static_cast<size_t>(m.ntendon)) {
  Names names(m);
  // Named bodies come first, so that generated names cannot take theirs.
  for (const bool has_name : {true, false}) {
    for (int body = 0; body < m.nbody; ++body) {
      if ((m.names[m.name_bodyadr[body]] != '\0') == has_name)
        bodies[static_cast<size_t>(body)] = names.free(m.name_bodyadr[body], "body", body);
    }
  }
  free_camera = names.free("free camera", "camera");
  for (int i = 0; i < m.ncam; ++i) cameras.push_back(names.free(m.name_camadr[i], "camera", i));
  for (int i = 0; i < m.nlight; ++i) lights.push_back(names.free(m.name_lightadr[i], "light", i));
  for (int i = 0; i < m.ntendon; ++i) {
    const int points = most_tendon_points(m, i);
    if (points < 2) continue;
    std::string tendon = printable(m.names + m.name_tendonadr[i]);
    if (tendon.empty()) tendon = "tendon_" + std::to_string(i);
    for (int piece = 0; piece + 1 < points; ++piece)
      tendon_pieces[static_cast<size_t>(i)].push_back(
          names.free(tendon + "#" + std::to_string(piece), "tendon"));
    for (int end = 0; end < points; ++end)
      tendon_ends[static_cast<size_t>(i)].push_back(
          names.free(tendon + "#end " + std::to_string(end), "tendon"));
  }
  for (int i = 0; i < m.ngeom; ++i) geoms.push_back(names.free(m.name_geomadr[i], "geom", i));
}

bool is_shown_group(int group) {
  return group < kShownGroups;
}

std::array<float, 4> mjcf_color(const mjModel& m, int material, const float* own) {
  const bool is_default = own[0] == 0.5f && own[1] == 0.5f && own[2] == 0.5f && own[3] == 1.0f;
  const float* from = material >= 0 && is_default ? m.mat_rgba + 4 * material : own;
  return {from[0], from[1], from[2], from[3]};
}

bool is_scene_light(const mjModel& m, int light) {
  const mjtNum* direction = m.light_dir + 3 * light;
  const float* diffuse = m.light_diffuse + 3 * light;
  const bool shines_somewhere = mju_norm3(direction) > 0;
  return m.light_active[light] && shines_somewhere &&
         std::any_of(diffuse, diffuse + 3, [](float c) { return c > 0; });
}

}  // namespace fire3dv::convert
