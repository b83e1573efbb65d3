// What stands around the arm: names, shapes, materials and first poses. The stream's frame is Bullet's here:
// Z up, metres, the arm's base at the origin, the audience at -Y.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <string>
#include <vector>

namespace bullet_arm {

enum class Shape { box, sphere, cylinder, capsule };

// The axis of cylinders and capsules is the body's Z.
struct Size {
  float x = 0;  // box: half extents. sphere, cylinder, capsule: x is the radius
  float y = 0;
  float z = 0;  // cylinder: half height. capsule: half length of the straight part
};

struct Object {
  std::string name;
  Shape shape = Shape::box;
  Size size;
  float mass_kg = 0;  // 0: does not move and is not streamed
  std::string material;
  btTransform stream_from_body = btTransform::getIdentity();
};

// Places that the arm's plan and the layout share. Angles are azimuths about Z.
constexpr float kHeldBoxAzimuth_rad = -2.88f;
constexpr float kHeldBoxRadius_m = 0.62f;
constexpr float kHeldBoxHalf_m = 0.03f;
constexpr float kPlinthHeight_m = 0.06f;
constexpr float kDominoRadius_m = 0.86f;
constexpr float kFirstDominoAzimuth_rad = -2.75f;

std::vector<Object> make_layout(uint64_t seed);

}  // namespace bullet_arm
