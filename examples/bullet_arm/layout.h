// What stands around the arm: names, shapes, materials and first poses. The stream's frame is Bullet's here:
// Z up, metres, the arm's base at the origin, the audience at -Y.
#pragma once

#include <cstdint>
#include <vector>

#include "examples/common/object.h"

namespace bullet_arm {

using examples::Object, examples::Shape, examples::Size;

// Places that the arm's plan and the layout share. Angles are azimuths about Z.
constexpr float kHeldBoxAzimuth_rad = -2.88f;
constexpr float kHeldBoxRadius_m = 0.62f;
constexpr float kHeldBoxHalf_m = 0.03f;
constexpr float kPlinthHeight_m = 0.06f;
constexpr float kDominoRadius_m = 0.86f;
constexpr float kFirstDominoAzimuth_rad = -2.75f;

std::vector<Object> make_layout(uint64_t seed);

}  // namespace bullet_arm
