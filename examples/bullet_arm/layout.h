// Objects around the arm: names, shapes, materials and initial poses. The stream frame is Bullet's world: Z
// up, metres, arm base at the origin, cameras at -Y.
#pragma once

#include <cstdint>
#include <vector>

#include "examples/common/object.h"

namespace bullet_arm {

using examples::Object, examples::Shape, examples::Size;

// Positions shared by motion script and layout. Angles are azimuths about Z.
constexpr float kHeldBoxAzimuth_rad = -2.88f;
constexpr float kHeldBoxRadius_m = 0.62f;
constexpr float kHeldBoxHalf_m = 0.03f;
constexpr float kPlinthHeight_m = 0.06f;
constexpr float kDominoRadius_m = 0.86f;
constexpr float kFirstDominoAzimuth_rad = -2.75f;

std::vector<Object> make_layout(uint64_t seed);

}  // namespace bullet_arm
