// A rigid body of an example: how large it is, what it is made of and where it starts.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <array>
#include <memory>
#include <string>

namespace examples {

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

// Bullet's shape of it, in a world of so many units a metre.
std::unique_ptr<btCollisionShape> make_shape(const Object& object, float units_per_m = 1);

// Row-major 3x4, as it is published.
std::array<float, 12> pose_of(const btTransform& stream_from_body);

}  // namespace examples
