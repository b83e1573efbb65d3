// Rigid body of an example: shape, size, mass, material and initial pose, and random numbers for the
// placement. Metres, kilograms.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <array>
#include <cstdint>
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

// Deterministic random numbers. Distributions of the standard library differ between implementations; here a
// seed gives the same scene everywhere.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}

  // splitmix64
  uint64_t next() {
    uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }

  // [low, high)
  float uniform(float low, float high) {
    return low + (high - low) * static_cast<float>(next() >> 40) * (1.0f / 16777216.0f);
  }

 private:
  uint64_t state_;
};

}  // namespace examples
