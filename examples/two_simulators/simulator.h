// Simulator interface of both programs (named bodies, poses and fixed time steps) and their stage. Stage
// frame: Z up, metres, origin at the centre of the table top, cameras at -Y. Each simulator has its own
// stream frame and sends world_from_stream with its description.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

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

constexpr double kStepsPerSecond = 240;

class Simulator {
 public:
  virtual ~Simulator() = default;

  virtual Frame frame() const = 0;
  virtual const std::vector<std::string>& names() const = 0;
  // 12 floats per body in the order of names(): stream_from_body, 3x4 row-major.
  virtual const std::vector<float>& poses() const = 0;
  // Advances by 1 / kStepsPerSecond. Returns false when the bodies jumped (discontinuity).
  virtual bool step() = 0;
};

}  // namespace two_simulators
