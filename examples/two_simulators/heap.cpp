#include "examples/two_simulators/heap.h"

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>

namespace two_simulators {
namespace {

using examples::Object;

constexpr double kCycleSeconds = 10;
constexpr float kUnits = kHeapUnitsPerM;

// Rests at first, then accelerates to a constant angular velocity.
float stirrer_angle_rad(double seconds) {
  const double begun = std::max(0.0, seconds - 0.6);
  constexpr double kRadPerSecond = 1.1, kSecondsToSpeed = 0.8;
  const double ramp = std::min(begun, kSecondsToSpeed);
  return static_cast<float>(kRadPerSecond * (begun - ramp + ramp * ramp / (2 * kSecondsToSpeed)));
}

btTransform stirrer_pose(double seconds) {
  return btTransform(btQuaternion(btVector3(0, 0, 1), stirrer_angle_rad(seconds)),
                     btVector3(0, 0, kStirrerZ_m * kUnits));
}

btTransform in_units(btTransform metres) {
  metres.setOrigin(metres.getOrigin() * kUnits);
  return metres;
}

}  // namespace

// Members are declared so that bodies are destroyed before the world.
struct Heap::World {
  World() {
    dynamics.setGravity(btVector3(0, 0, -9.81f * kUnits));
    dynamics.getSolverInfo().m_numIterations = 16;
    add_static(new btStaticPlaneShape(btVector3(0, 0, 1), kFloorZ_m * kUnits), btTransform::getIdentity());
    const btVector3 table(kTableHalf_m.x, kTableHalf_m.y, kTableHalf_m.z);
    add_static(new btBoxShape(table * kUnits),
               in_units(btTransform(btQuaternion::getIdentity(),
                                    btVector3(-kHeapAt_m.x, -kHeapAt_m.y, -kTableHalf_m.z))));
    add_stirrer();
    for (const Object& object : heap_layout()) {
      btRigidBody* body =
          add(examples::make_shape(object, kUnits), object.mass_kg, in_units(object.stream_from_body));
      if (object.mass_kg > 0) streamed.push_back(body);
    }
  }
  ~World() {
    for (auto& body : bodies) dynamics.removeRigidBody(body.get());
  }

  btRigidBody* add(std::unique_ptr<btCollisionShape> shape, float mass_kg, const btTransform& pose) {
    btVector3 inertia(0, 0, 0);
    if (mass_kg > 0) shape->calculateLocalInertia(mass_kg, inertia);
    btRigidBody::btRigidBodyConstructionInfo info(mass_kg, nullptr, shape.get(), inertia);
    info.m_startWorldTransform = pose;
    info.m_friction = 0.5f;
    info.m_restitution = 0.1f;
    info.m_linearDamping = 0.02f;
    info.m_angularDamping = 0.08f;
    shapes.push_back(std::move(shape));
    bodies.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody* body = bodies.back().get();
    body->setActivationState(DISABLE_DEACTIVATION);  // kinematic bodies do not wake sleeping ones
    if (mass_kg > 0) body->setRollingFriction(0.002f * kUnits), body->setSpinningFriction(0.002f * kUnits);
    dynamics.addRigidBody(body);
    return body;
  }
  void add_static(btCollisionShape* shape, const btTransform& pose) {
    add(std::unique_ptr<btCollisionShape>(shape), 0, pose);
  }
  void add_stirrer() {
    const auto part = [&](Object object) {
      shapes.push_back(examples::make_shape(object, kUnits));
      return shapes.back().get();
    };
    auto whole = std::make_unique<btCompoundShape>();
    whole->addChildShape(btTransform::getIdentity(),
                         part({{}, examples::Shape::cylinder, {kStirrerHub_m, 0, kStirrerHubHalf_m}}));
    const examples::Size half{kStirrerBladeHalf_m.x, kStirrerBladeHalf_m.y, kStirrerBladeHalf_m.z};
    for (const float side : {-1.0f, 1.0f}) {
      whole->addChildShape(
          btTransform(btQuaternion::getIdentity(), btVector3(side * kStirrerBladeAt_m * kUnits, 0, -1.8f)),
          part({{}, examples::Shape::box, half}));
    }
    stirrer = add(std::move(whole), 0, stirrer_pose(0));
    stirrer->setCollisionFlags(stirrer->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
  }

  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld dynamics{&dispatcher, &broadphase, &solver, &configuration};
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  btRigidBody* stirrer = nullptr;
  std::vector<btRigidBody*> streamed;
};

Heap::Heap() {
  names_.push_back(kStirrerName);
  for (const Object& object : heap_layout())
    if (object.mass_kg > 0) names_.push_back(object.name);
  poses_.resize(names_.size() * 12);
  begin();
}

Heap::~Heap() = default;

void Heap::begin() {
  world_.reset();
  world_ = std::make_unique<World>();
  steps_ = 0;
  read_poses();
}

bool Heap::step() {
  constexpr auto kStep = static_cast<float>(1 / kStepsPerSecond);
  if (static_cast<double>(++steps_) >= kCycleSeconds * kStepsPerSecond) {
    begin();
    return false;
  }
  const btTransform before = world_->stirrer->getWorldTransform();
  const btTransform pose = stirrer_pose(static_cast<double>(steps_) / kStepsPerSecond);
  world_->stirrer->setInterpolationWorldTransform(before);
  world_->stirrer->setWorldTransform(pose);
  world_->stirrer->saveKinematicState(kStep);  // transfers the stirrer's velocity to bodies in contact
  // No sub-steps: each call is one step, independent of the wall clock.
  world_->dynamics.stepSimulation(kStep, 0, kStep);
  read_poses();
  return true;
}

void Heap::read_poses() {
  auto out = poses_.begin();
  const auto add = [&](const btRigidBody& body) {
    const Matrix pose = examples::pose_of(body.getWorldTransform());
    out = std::copy(pose.begin(), pose.end(), out);
  };
  add(*world_->stirrer);
  for (const btRigidBody* body : world_->streamed) add(*body);
}

}  // namespace two_simulators
