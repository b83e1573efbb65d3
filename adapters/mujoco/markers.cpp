#include "adapters/mujoco/markers.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

#include "adapters/mujoco/compiled/compiled_scene.h"
#include "base/text.h"

namespace fire3dv::mujoco {
namespace {

constexpr struct {
  const char* name;
  Quantity quantity;
} kQuantities[] = {{"contacts", kShowContacts},
                   {"forces", kShowForces},
                   {"joints", kShowJoints},
                   {"com", kShowCentresOfMass},
                   {"tendons", kShowTendons}};

constexpr const char *kContactPoints = "contacts/points", *kContactForces = "contacts/forces",
                     *kHinges = "joints/hinges", *kSlides = "joints/slides", *kBalls = "joints/balls",
                     *kTrees = "com/trees", *kTendonPaths = "tendons/paths";

using Point = std::array<float, 3>;

// False beyond the range that the wire takes, as in a simulation that has diverged.
bool to_point(const mjtNum* from, Point& to) {
  constexpr mjtNum kLargest = 1e9;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(std::fabs(from[axis]) <= kLargest)) return false;
    to[static_cast<size_t>(axis)] = static_cast<float>(from[axis]);
  }
  return true;
}

std::array<uint8_t, 4> bytes_of(const float* rgba) {
  std::array<uint8_t, 4> bytes{};
  for (size_t i = 0; i < 4; ++i) {
    const float value = rgba[i] >= 0 ? std::min(rgba[i], 1.0f) : 0.0f;  // 0 for NaN
    bytes[i] = static_cast<uint8_t>(std::lround(value * 255));
  }
  return bytes;
}

// Length of a decoration, from its scale in the model.
float length_of(const mjModel& m, double scale) {
  constexpr double kLargest_m = 1e6;
  const double length_m = scale * m.stat.meansize;
  return length_m >= 0 ? static_cast<float>(std::min(length_m, kLargest_m)) : 0.0f;
}

void add_segment(SimulationMarker& to, const mjtNum* begin, const mjtNum* end) {
  Point first{}, last{};
  if (!to_point(begin, first) || !to_point(end, last)) return;
  to.positions.push_back(first);
  to.positions.push_back(last);
}

}  // namespace

Result<uint32_t> shown_quantities(std::string_view text) {
  uint32_t bits = 0;
  while (true) {
    const size_t comma = text.find(',');
    const std::string_view name = text.substr(0, comma);
    const auto found = std::ranges::find_if(kQuantities, [&](const auto& each) { return name == each.name; });
    if (found == std::end(kQuantities))
      return Error{quote(name) + " is none of contacts, forces, joints, com, tendons"};
    if (bits & found->quantity) return Error{quote(name) + " is given twice"};
    bits |= found->quantity;
    if (comma == text.npos) return bits;
    text.remove_prefix(comma + 1);
  }
}

fire3dv_marker marker_of(const SimulationMarker& marker) {
  fire3dv_marker view{};
  view.struct_size = sizeof view;
  view.kind = marker.kind;
  view.width_unit = FIRE3DV_MARKER_LENGTHS;
  view.width = marker.width_m;
  view.flags = FIRE3DV_MARKER_OVERLAID;
  if (marker.positions.empty()) return view;
  view.positions = marker.positions.front().data();
  view.position_count = marker.positions.size();
  if (!marker.sizes.empty()) view.sizes = marker.sizes.front().data();
  view.size_count = marker.sizes.size();
  if (!marker.colors.empty()) view.colors = marker.colors.front().data();
  view.color_count = marker.colors.size();
  return view;
}

SimulationMarkers::SimulationMarkers(uint32_t quantities) : quantities_(quantities) {
  const auto add = [&](Quantity quantity, const char* name, int32_t kind) {
    if (!(quantities & quantity)) return;
    SimulationMarker& added = markers_.emplace_back();
    added.name = name;
    added.kind = kind;
  };
  add(kShowContacts, kContactPoints, FIRE3DV_MARKER_POINTS);
  add(kShowForces, kContactForces, FIRE3DV_MARKER_ARROWS);
  add(kShowJoints, kHinges, FIRE3DV_MARKER_ARROWS);
  add(kShowJoints, kSlides, FIRE3DV_MARKER_ARROWS);
  add(kShowJoints, kBalls, FIRE3DV_MARKER_SPHERES);
  add(kShowCentresOfMass, kTrees, FIRE3DV_MARKER_SPHERES);
  add(kShowTendons, kTendonPaths, FIRE3DV_MARKER_LINES);
}

SimulationMarker& SimulationMarkers::marker(const char* name) {
  const auto found = std::ranges::find(markers_, name, &SimulationMarker::name);
  FIRE3DV_ASSERT(found != markers_.end());
  return *found;
}

const std::vector<SimulationMarker>& SimulationMarkers::update(const mjModel& m, const mjData& d) {
  for (SimulationMarker& each : markers_) {
    each.is_changed = !each.positions.empty();
    each.positions.clear();
    each.sizes.clear();
    each.colors.clear();
  }
  if (quantities_ & kShowContacts) add_contacts(m, d);
  if (quantities_ & kShowForces) add_forces(m, d);
  if (quantities_ & kShowJoints) add_joints(m, d);
  if (quantities_ & kShowCentresOfMass) add_centres_of_mass(m, d);
  if (quantities_ & kShowTendons) add_tendons(m, d);
  for (SimulationMarker& each : markers_) each.is_changed |= !each.positions.empty();
  return markers_;
}

void SimulationMarkers::add_contacts(const mjModel& m, const mjData& d) {
  SimulationMarker& to = marker(kContactPoints);
  to.width_m = length_of(m, 2.0 * m.vis.scale.contactwidth);  // MuJoCo's is a radius
  for (int i = 0; i < d.ncon; ++i) {
    Point position{};
    if (!to_point(d.contact[i].pos, position)) continue;
    to.positions.push_back(position);
    const bool is_active = d.contact[i].efc_address >= 0;  // else within the margin and without a force
    to.colors.push_back(bytes_of(is_active ? m.vis.rgba.contactpoint : m.vis.rgba.contactgap));
  }
}

void SimulationMarkers::add_forces(const mjModel& m, const mjData& d) {
  SimulationMarker& to = marker(kContactForces);
  to.width_m = length_of(m, 2.0 * m.vis.scale.forcewidth);
  to.colors = {bytes_of(m.vis.rgba.contactforce)};
  const mjtNum metres_per_newton = m.vis.map.force / std::max<mjtNum>(m.stat.meanmass, mjMINVAL);
  for (int i = 0; i < d.ncon; ++i) {
    const mjContact& contact = d.contact[i];
    mjtNum wrench[6], arrow[3], tip[3];
    mj_contactForce(&m, &d, i, wrench);
    // The normal points from the first geom to the second, so that this is the force on the second.
    mju_rotVecMatT(arrow, wrench, contact.frame);
    const bool is_reversed = m.geom_bodyid[contact.geom1] > m.geom_bodyid[contact.geom2];
    mju_scl3(arrow, arrow, is_reversed ? -metres_per_newton : metres_per_newton);
    if (!(mju_norm3(arrow) > mjMINVAL)) continue;
    mju_add3(tip, contact.pos, arrow);
    add_segment(to, contact.pos, tip);
  }
}

void SimulationMarkers::add_joints(const mjModel& m, const mjData& d) {
  SimulationMarker &hinges = marker(kHinges), &slides = marker(kSlides), &balls = marker(kBalls);
  const float length_m = length_of(m, m.vis.scale.jointlength);
  const float width_m = length_of(m, 2.0 * m.vis.scale.jointwidth);
  hinges.width_m = slides.width_m = width_m;
  hinges.colors = slides.colors = balls.colors = {bytes_of(m.vis.rgba.joint)};
  balls.sizes = {{2 * width_m, 2 * width_m, 2 * width_m}};
  for (int joint = 0; joint < m.njnt; ++joint) {
    if (!convert::is_shown_group(m.jnt_group[joint])) continue;
    const mjtNum* anchor = d.xanchor + 3 * joint;
    if (m.jnt_type[joint] == mjJNT_BALL) {
      Point position{};
      if (to_point(anchor, position)) balls.positions.push_back(position);
    } else if (m.jnt_type[joint] != mjJNT_FREE) {
      mjtNum tip[3];
      mju_addScl3(tip, anchor, d.xaxis + 3 * joint, length_m);
      add_segment(m.jnt_type[joint] == mjJNT_HINGE ? hinges : slides, anchor, tip);
    }
  }
}

void SimulationMarkers::add_centres_of_mass(const mjModel& m, const mjData& d) {
  SimulationMarker& to = marker(kTrees);
  const float diameter_m = length_of(m, 2.0 * m.vis.scale.com);
  to.sizes = {{diameter_m, diameter_m, diameter_m}};
  to.colors = {bytes_of(m.vis.rgba.com)};
  for (int body = 1; body < m.nbody; ++body) {
    Point position{};
    const bool is_root = m.body_rootid[body] == body;
    if (!is_root || !(m.body_subtreemass[body] > mjMINVAL)) continue;
    if (to_point(d.subtree_com + 3 * body, position)) to.positions.push_back(position);
  }
}

void SimulationMarkers::add_tendons(const mjModel& m, const mjData& d) {
  constexpr int kPulley = -2;  // in wrap_obj: ends one branch of the tendon
  SimulationMarker& to = marker(kTendonPaths);
  to.width_m = length_of(m, m.vis.scale.connect);
  for (int tendon = 0; tendon < m.ntendon; ++tendon) {
    if (!convert::is_shown_group(m.tendon_group[tendon])) continue;
    const auto rgba = convert::compiled_color(m, m.tendon_matid[tendon], m.tendon_rgba + 4 * tendon);
    const int first = d.ten_wrapadr[tendon], end = first + d.ten_wrapnum[tendon];
    for (int i = first; i + 1 < end; ++i) {
      if (d.wrap_obj[i] == kPulley || d.wrap_obj[i + 1] == kPulley) continue;
      add_segment(to, d.wrap_xpos + 3 * i, d.wrap_xpos + 3 * (i + 1));
      to.colors.resize(to.positions.size(), bytes_of(rgba.data()));
    }
  }
}

}  // namespace fire3dv::mujoco
