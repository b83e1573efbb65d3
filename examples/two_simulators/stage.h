// Stage frame of both simulators: Z up, metres, origin at the centre of the table top, cameras at -Y. Each
// simulator has its own stream frame and sends world_from_stream with its description.
#pragma once

#include <array>

#include "examples/common/mesh.h"

namespace two_simulators {

using Matrix = std::array<float, 12>;  // 3x4, row-major

constexpr examples::Vec3 kTableHalf_m{0.80f, 0.44f, 0.022f};
constexpr float kFloorZ_m = -0.74f;

constexpr examples::Vec3 kHeapAt_m{-0.37f, 0, 0};         // Bullet's origin: tray centre
constexpr examples::Vec3 kCarouselAt_m{0.36f, 0.03f, 0};  // MuJoCo's origin: foot of the carousel

// Stream frame: the stage frame translated to at_m, with unit_m metres per unit.
struct Frame {
  examples::Vec3 at_m;
  double unit_m;

  std::array<double, 12> world_from_stream() const {
    return {unit_m, 0,       0,      static_cast<double>(at_m.x),  //
            0,      0,       unit_m, static_cast<double>(at_m.z),  //
            0,      -unit_m, 0,      -static_cast<double>(at_m.y)};
  }
  // Meshes in the scene file are Y up, in metres, whatever the simulator's unit.
  Matrix body_from_node() const {
    const auto units_per_m = static_cast<float>(1 / unit_m);
    return {units_per_m, 0, 0, 0, 0, 0, -units_per_m, 0, 0, units_per_m, 0, 0};
  }
};

// Bullet's tolerances suit bodies of about one unit, hence centimetres.
constexpr float kHeapUnitsPerM = 100;
constexpr Frame kHeapFrame{kHeapAt_m, 1.0 / 100};
constexpr Frame kCarouselFrame{kCarouselAt_m, 1};

}  // namespace two_simulators
