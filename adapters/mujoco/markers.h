// Markers of a MuJoCo simulation: contacts, contact forces, joints, centres of mass and tendons, with the
// sizes and colours that the model gives them (`visual/scale`, `visual/rgba`). Frame: MuJoCo's world, metres.
#pragma once

#include <fire3dv/markers.h>
#include <mujoco/mujoco.h>

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace fire3dv::mujoco {

// Bits of a set of quantities.
enum Quantity : uint32_t {
  kShowContacts = 1u << 0,
  kShowForces = 1u << 1,
  kShowJoints = 1u << 2,
  kShowCentresOfMass = 1u << 3,
  kShowTendons = 1u << 4,
};

// Parses "contacts,forces" to Quantity bits. The error lists the valid names.
Result<uint32_t> shown_quantities(std::string_view text);

struct SimulationMarker {
  const char* name = nullptr;  // "namespace/name"
  int32_t kind = FIRE3DV_MARKER_POINTS;
  float width_m = 0;
  std::vector<std::array<float, 3>> positions;
  std::vector<std::array<float, 3>> sizes;     // of spheres: one for all
  std::vector<std::array<uint8_t, 4>> colors;  // one for all, or one per position
  bool is_changed = false;                     // by the last update; false while it has no elements
};

// A view of the marker; its arrays are the marker's. All are overlaid, since most are inside bodies.
fire3dv_marker marker_of(const SimulationMarker& marker);

class SimulationMarkers {
 public:
  // quantities: Quantity bits; 0: no markers.
  explicit SimulationMarkers(uint32_t quantities);

  // Returns all markers in the state of `data`. Requires mj_kinematics, mj_comPos and mj_tendon. Contacts are
  // those of the last mj_step or mj_forward. Skips elements that are not finite.
  const std::vector<SimulationMarker>& update(const mjModel& model, const mjData& data);

 private:
  void add_contacts(const mjModel& model, const mjData& data);
  void add_forces(const mjModel& model, const mjData& data);
  void add_joints(const mjModel& model, const mjData& data);
  void add_centres_of_mass(const mjModel& model, const mjData& data);
  void add_tendons(const mjModel& model, const mjData& data);
  SimulationMarker& marker(const char* name);

  uint32_t quantities_;
  std::vector<SimulationMarker> markers_;
};

}  // namespace fire3dv::mujoco
