#include "examples/common/object.h"

#include <cmath>

namespace examples {
namespace {

// Cylinder collision shape as a prism. Bullet finds a full contact patch between polyhedra at once. A
// btCylinderShape gets one contact point per step, so that stacks wobble and fall.
std::unique_ptr<btConvexHullShape> make_prism(float radius, float half_height) {
  constexpr int kSides = 24;
  auto prism = std::make_unique<btConvexHullShape>();
  for (int i = 0; i < kSides; ++i) {
    const float angle = 6.2831853f * static_cast<float>(i) / kSides;
    for (float z : {-half_height, half_height}) {
      prism->addPoint(btVector3(radius * std::cos(angle), radius * std::sin(angle), z), false);
    }
  }
  prism->recalcLocalAabb();
  return prism;
}

}  // namespace

std::unique_ptr<btCollisionShape> make_shape(const Object& object, float units_per_m) {
  const Size s{object.size.x * units_per_m, object.size.y * units_per_m, object.size.z * units_per_m};
  std::unique_ptr<btPolyhedralConvexShape> shape;
  switch (object.shape) {
    case Shape::sphere:
      return std::make_unique<btSphereShape>(s.x);  // its margin is the radius
    case Shape::capsule:
      return std::make_unique<btCapsuleShapeZ>(s.x, 2 * s.z);
    case Shape::box:
      shape = std::make_unique<btBoxShape>(btVector3(s.x, s.y, s.z));
      break;
    case Shape::cylinder:
      shape = make_prism(s.x, s.z);
      break;
  }
  // Bullet's default margin of 4 cm is as large as these objects. A hull's margin lies outside its points.
  shape->setMargin(object.shape == Shape::cylinder ? 0.0f : 0.002f * units_per_m);
  shape->initializePolyhedralFeatures();
  return shape;
}

std::array<float, 12> pose_of(const btTransform& stream_from_body) {
  std::array<float, 12> pose;
  float* out = pose.data();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      *out++ = static_cast<float>(stream_from_body.getBasis()[row][column]);
    *out++ = static_cast<float>(stream_from_body.getOrigin()[row]);
  }
  return pose;
}

}  // namespace examples
