#include "tools/convert/mjcf/mjcf_nodes.h"

#include <algorithm>
#include <set>

#include "tools/convert/model.h"

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

namespace {

constexpr int kPulley = -2;  // marker in mjData::wrap_obj: the path restarts behind it

glm::dvec3 vec3(const mjtNum* v) {
  return {v[0], v[1], v[2]};
}

}  // namespace

int most_tendon_points(const mjModel& m, int tendon) {
  const float opacity = mjcf_color(m, m.tendon_matid[tendon], m.tendon_rgba + 4 * tendon)[3];
  if (!is_shown_group(m.tendon_group[tendon]) || !(opacity > 0) || !(m.tendon_width[tendon] > 0)) return 0;
  int points = 0;
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
    pieces.push_back({vec3(d.wrap_xpos + 3 * i), vec3(d.wrap_xpos + 3 * (i + 1)),
                      m.tendon_width[tendon] * (lies_on_geom ? 0.5 : 1)});
  }
}

TendonFrame piece_frame(const TendonPiece& piece) {
  const glm::dvec3 way = piece.to - piece.from;
  const double length = glm::length(way);
  TendonFrame frame;
  frame.place = 0.5 * (piece.from + piece.to);
  if (length > 0) frame.turn = glm::mat3_cast(shining(-way));
  frame.scale = {piece.radius_m, piece.radius_m, length / 2};
  return frame;
}

void tendon_frames(const mjModel& m, const mjData& d, int tendon, std::vector<TendonPiece>& pieces,
                   std::vector<TendonFrame>& frames) {
  const int points = most_tendon_points(m, tendon);
  frames.assign(static_cast<size_t>(std::max(2 * points - 1, 0)), {});
  if (points == 0) return;
  tendon_pieces(m, d, tendon, pieces);
  const size_t most_pieces = static_cast<size_t>(points) - 1;
  size_t end = most_pieces;
  const auto add_ball = [&](const glm::dvec3& place, double radius_m) {
    if (end < frames.size()) frames[end++] = {place, glm::dmat3(1), glm::dvec3(radius_m)};
  };
  for (size_t i = 0; i < pieces.size() && i < most_pieces; ++i) {
    frames[i] = piece_frame(pieces[i]);
    const bool switches_document = i > 0 && pieces[i - 1].to == pieces[i].from;
    // A ball between two segments takes the larger radius.
    add_ball(pieces[i].from,
             switches_document ? std::max(pieces[i - 1].radius_m, pieces[i].radius_m) : pieces[i].radius_m);
    if (i + 1 == pieces.size() || pieces[i + 1].from != pieces[i].to)
      add_ball(pieces[i].to, pieces[i].radius_m);
  }
  const glm::dvec3 rest = pieces.empty() ? glm::dvec3(0) : pieces.back().to;
  for (size_t i = pieces.size(); i < most_pieces; ++i) frames[i].place = rest;
  for (; end < frames.size(); ++end) frames[end].place = rest;
}

}  // namespace fire3dv::convert
