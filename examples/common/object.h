// Rigid body of an example: shape, size, mass, material and initial pose. Metres, kilograms.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <array>
#include <memory>
#include <string>

namespace examples {

enum class Shape { box, sphere, cylinder, capsule };

// Cylinder and capsule axes are the body's Z.
struct Size {
  float x = 0;  // box: half extent; sphere, cylinder, capsule: radius
  float y = 0;
  float z = 0;  // box: half extent; cylinder: half height; capsule: half length of the straight part
};

struct Object {
  std::string name;
  Shape shape = Shape::box;
  Size size;
  float mass_kg = 0;  // 0: static and not streamed
  std::string material;
  btTransform stream_from_body = btTransform::getIdentity();
};

// Creates the Bullet collision shape, scaled to units_per_m.
std::unique_ptr<btCollisionShape> make_shape(const Object& object, float units_per_m = 1);

// Converts to the published layout: 3x4, row-major.
std::array<float, 12> pose_of(const btTransform& stream_from_body);

}  // namespace examples
