// Where both simulators stand. The stage is Z up, metres, its origin in the middle of the table's top, the
// audience at -Y. Each simulator has a frame of its own and says with its stream how that lies in the world.
#pragma once

#include <array>

#include "examples/common/mesh.h"

namespace two_simulators {

using Matrix = std::array<float, 12>;  // row-major 3x4

constexpr examples::Vec3 kTableHalf_m{0.80f, 0.44f, 0.022f};
constexpr float kFloorZ_m = -0.74f;

constexpr examples::Vec3 kHeapAt_m{-0.37f, 0, 0};         // Bullet's origin: the tray's middle
constexpr examples::Vec3 kCarouselAt_m{0.36f, 0.03f, 0};  // MuJoCo's: the carousel's foot

// What a simulator's stream says: its frame is the stage's, moved to `at`, in units of so many metres.
struct Frame {
  examples::Vec3 at_m;
  double unit_m;

  std::array<double, 12> world_from_stream() const {
    return {unit_m, 0,       0,      static_cast<double>(at_m.x),  //
            0,      0,       unit_m, static_cast<double>(at_m.z),  //
            0,      -unit_m, 0,      -static_cast<double>(at_m.y)};
  }
  // The file's meshes are Y up and in metres, whatever the simulator's unit is.
  Matrix body_from_node() const {
    const auto units_per_m = static_cast<float>(1 / unit_m);
    return {units_per_m, 0, 0, 0, 0, 0, -units_per_m, 0, 0, units_per_m, 0, 0};
  }
};

// Bullet's tolerances suit bodies about as large as its unit: centimetres here.
constexpr float kHeapUnitsPerM = 100;
constexpr Frame kHeapFrame{kHeapAt_m, 1.0 / 100};
constexpr Frame kCarouselFrame{kCarouselAt_m, 1};

}  // namespace two_simulators
