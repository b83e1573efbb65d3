#include "renderer/dataset/randomize/settle.h"

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace fire3dv::dataset {
namespace {

// Bodies are scaled to a size of 1 and fall slowly, since Bullet's tolerances are for bodies of that size:
// only the pose at rest counts.
constexpr float kGravity = 10;       // sizes per second squared
constexpr float kStep = 1.0f / 240;  // seconds
constexpr float kMargin = 0.002f;    // of shapes, in sizes
constexpr float kFriction = 0.8f, kRollingFriction = 0.02f;
constexpr float kLinearDamping = 0.05f, kAngularDamping = 0.3f;

btVector3 vector_of(const glm::dvec3& v) {
  return {static_cast<btScalar>(v.x), static_cast<btScalar>(v.y), static_cast<btScalar>(v.z)};
}

// A body of Bullet: its origin is the centre of its bounding box.
struct Dropped {
  std::vector<std::unique_ptr<btConvexHullShape>> hulls;
  btCompoundShape compound;
  std::unique_ptr<btRigidBody> body;
  glm::dvec3 centre_m{0};  // in the body's axes
  double radius_m = 0;
};

// Sets centre and radius. Returns false for a body without extent.
bool measure(const FallingBody& from, Dropped& to) {
  glm::vec3 low(INFINITY), high(-INFINITY);
  for (const Hull& hull : from.hulls) {
    for (const glm::vec3& point : hull) {
      low = glm::min(low, point);
      high = glm::max(high, point);
    }
  }
  if (!(low.x <= high.x)) return false;
  to.centre_m = 0.5 * (glm::dvec3(low) + glm::dvec3(high));
  to.radius_m = 0.5 * glm::length(glm::dvec3(high) - glm::dvec3(low));
  return std::isfinite(to.radius_m) && to.radius_m > 0;
}

void make_body(const FallingBody& from, double units_per_m, Dropped& to) {
  for (const Hull& points : from.hulls) {
    auto hull = std::make_unique<btConvexHullShape>();
    for (const glm::vec3& point : points)
      hull->addPoint(vector_of((glm::dvec3(point) - to.centre_m) * units_per_m), false);
    hull->recalcLocalAabb();
    hull->setMargin(kMargin);
    to.compound.addChildShape(btTransform::getIdentity(), hull.get());
    to.hulls.push_back(std::move(hull));
  }
  to.compound.setMargin(kMargin);
  constexpr btScalar kMass = 1;
  btVector3 inertia(0, 0, 0);
  to.compound.calculateLocalInertia(kMass, inertia);
  btRigidBody::btRigidBodyConstructionInfo info(kMass, nullptr, &to.compound, inertia);
  info.m_startWorldTransform.setOrigin(
      vector_of((from.position_m + from.rotation * to.centre_m) * units_per_m));
  info.m_startWorldTransform.setRotation(
      btQuaternion(static_cast<btScalar>(from.rotation.x), static_cast<btScalar>(from.rotation.y),
                   static_cast<btScalar>(from.rotation.z), static_cast<btScalar>(from.rotation.w)));
  info.m_friction = kFriction;
  info.m_rollingFriction = kRollingFriction;
  info.m_spinningFriction = kRollingFriction;
  info.m_linearDamping = kLinearDamping;
  info.m_angularDamping = kAngularDamping;
  info.m_linearSleepingThreshold = 0.05f;
  info.m_angularSleepingThreshold = 0.1f;
  to.body = std::make_unique<btRigidBody>(info);
  // Thin floors are not missed by fast bodies.
  const auto radius = static_cast<btScalar>(to.radius_m * units_per_m);
  to.body->setCcdMotionThreshold(0.3f * radius);
  to.body->setCcdSweptSphereRadius(0.2f * radius);
}

}  // namespace

Result<std::vector<RestingBody>> settle(const FixedTriangles& fixed, std::span<const FallingBody> bodies) {
  if (fixed.indices.size() / 3 > kMaxFixedTriangles)
    return Error{"settle: bodies would fall onto more than " + std::to_string(kMaxFixedTriangles) +
                 " triangles: hide some, or choose a simpler scene"};
  std::vector<std::unique_ptr<Dropped>> dropped;
  double log_sum = 0;
  for (const FallingBody& body : bodies) {
    dropped.push_back(std::make_unique<Dropped>());
    if (!measure(body, *dropped.back())) return Error{"settle: a body has no extent"};
    log_sum += std::log(dropped.back()->radius_m);
  }
  if (bodies.empty()) return std::vector<RestingBody>();
  const double units_per_m = 1 / std::exp(log_sum / static_cast<double>(bodies.size()));

  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity(btVector3(0, -kGravity, 0));

  std::vector<glm::vec3> positions;  // in sizes
  positions.reserve(fixed.positions_m.size());
  double lowest = INFINITY;
  for (const glm::vec3& position : fixed.positions_m) {
    positions.emplace_back(glm::dvec3(position) * units_per_m);
    lowest = std::min(lowest, static_cast<double>(positions.back().y));
  }
  std::vector<int> indices(fixed.indices.begin(), fixed.indices.end());
  std::unique_ptr<btTriangleIndexVertexArray> triangles;
  std::unique_ptr<btBvhTriangleMeshShape> ground_shape;
  std::unique_ptr<btRigidBody> ground;
  if (!indices.empty()) {
    triangles = std::make_unique<btTriangleIndexVertexArray>(
        static_cast<int>(indices.size() / 3), indices.data(), static_cast<int>(3 * sizeof(int)),
        static_cast<int>(positions.size()), &positions[0].x, static_cast<int>(sizeof(glm::vec3)));
    ground_shape = std::make_unique<btBvhTriangleMeshShape>(triangles.get(), true);
    ground_shape->setMargin(kMargin);
    btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, ground_shape.get());
    info.m_friction = kFriction;
    info.m_rollingFriction = kRollingFriction;
    info.m_spinningFriction = kRollingFriction;
    ground = std::make_unique<btRigidBody>(info);
    world.addRigidBody(ground.get());
  }
  for (size_t i = 0; i < bodies.size(); ++i) {
    make_body(bodies[i], units_per_m, *dropped[i]);
    world.addRigidBody(dropped[i]->body.get());
  }
  const auto is_awake = [](const auto& each) { return each->body->isActive(); };
  for (uint32_t step = 0; step < kMaxSettleSteps; ++step) {
    world.stepSimulation(kStep, 0, kStep);
    if (std::none_of(dropped.begin(), dropped.end(), is_awake)) break;
  }

  std::vector<RestingBody> resting;
  for (size_t i = 0; i < bodies.size(); ++i) {
    const Dropped& each = *dropped[i];
    const btTransform& pose = each.body->getWorldTransform();
    const btQuaternion turn = pose.getRotation();
    const btVector3& origin = pose.getOrigin();
    RestingBody& result = resting.emplace_back();
    result.rotation = glm::normalize(glm::dquat(turn.w(), turn.x(), turn.y(), turn.z()));
    result.position_m =
        glm::dvec3(origin.x(), origin.y(), origin.z()) / units_per_m - result.rotation * each.centre_m;
    result.is_at_rest = !is_awake(dropped[i]);
    const bool is_finite = std::isfinite(glm::length(result.position_m)) && std::isfinite(turn.length());
    result.has_fallen = !is_finite || !(origin.y() + each.radius_m * units_per_m > lowest);
    if (!result.has_fallen) continue;
    result.rotation = bodies[i].rotation;
    result.position_m = bodies[i].position_m;
  }
  for (const auto& each : dropped) world.removeRigidBody(each->body.get());
  if (ground) world.removeRigidBody(ground.get());
  return resting;
}

}  // namespace fire3dv::dataset
