#include "examples/bullet_arm/simulation.h"

#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <cstring>

#include "examples/bullet_arm/arm.h"

namespace bullet_arm {
namespace {

// How far ahead contacts are kept, as a share of a body's size. More than Bullet's 0.02, because a block
// flies 1 cm in a step and is to be stopped at the floor, not below it; at 0.08 stale contacts begin to tip
// the stack of cans.
constexpr float kContactAhead = 0.05f;

// A prism instead of btCylinderShape: between polyhedra Bullet finds a whole patch of contact at once, while
// a true cylinder gets one point a step and a stack of them wobbles until it falls.
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

std::unique_ptr<btCollisionShape> make_shape(const Object& object) {
  const Size& s = object.size;
  std::unique_ptr<btPolyhedralConvexShape> shape;
  switch (object.shape) {
    case Shape::sphere:
      return std::make_unique<btSphereShape>(s.x);  // its margin is its radius
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
  shape->setMargin(object.shape == Shape::cylinder ? 0.0f : 0.002f);
  shape->initializePolyhedralFeatures();
  return shape;
}

}  // namespace

// Members are destroyed from the last to the first: bodies leave before the world does.
struct Simulation::World {
  explicit World(float seconds)
      : step_s(seconds), dynamics(&dispatcher, &broadphase, &solver, &configuration) {
    gContactBreakingThreshold = kContactAhead;
    dynamics.setGravity(btVector3(0, 0, -9.81f));
    dynamics.getSolverInfo().m_numIterations = 60;
    dynamics.getSolverInfo().m_splitImpulse = 1;
    floor_body.setFriction(0.8f);
    dynamics.addRigidBody(&floor_body);
    arm = std::make_unique<Arm>(dynamics, seconds);
  }
  ~World() {
    for (auto& body : bodies) dynamics.removeRigidBody(body.get());
    dynamics.removeRigidBody(&floor_body);
  }

  btRigidBody* add(const Object& object) {
    shapes.push_back(make_shape(object));
    btCollisionShape* shape = shapes.back().get();
    btVector3 inertia(0, 0, 0);
    if (object.mass_kg > 0) shape->calculateLocalInertia(object.mass_kg, inertia);
    btRigidBody::btRigidBodyConstructionInfo info(object.mass_kg, nullptr, shape, inertia);
    info.m_startWorldTransform = object.stream_from_body;
    info.m_friction = object.shape == Shape::box ? 0.55f : 0.45f;
    info.m_restitution = 0.05f;
    info.m_linearDamping = 0.03f;
    info.m_angularDamping = 0.05f;
    bodies.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody* body = bodies.back().get();
    if (object.shape != Shape::box) {
      // On what rolls only: Bullet adds both bodies' shares, and a share of the floor would hold dominoes
      // upright.
      body->setRollingFriction(0.0015f);
      body->setSpinningFriction(0.0015f);
    }
    // A sleeping island is not woken reliably by a multi-body that moves into it.
    body->setActivationState(DISABLE_DEACTIVATION);
    dynamics.addRigidBody(body);
    return body;
  }

  float step_s;
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btMultiBodyConstraintSolver solver;
  btMultiBodyDynamicsWorld dynamics;
  btStaticPlaneShape floor_shape{btVector3(0, 0, 1), 0};
  btRigidBody floor_body{btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &floor_shape)};
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  std::vector<btRigidBody*> streamed;
  std::unique_ptr<Arm> arm;
};

Simulation::Simulation(uint64_t seed, double rate_hz) : rate_hz_(rate_hz), layout_(make_layout(seed)) {
  world_ = std::make_unique<World>(static_cast<float>(1.0 / rate_hz));
  names_ = kArmNames;
  for (const Object& object : layout_) {
    btRigidBody* body = world_->add(object);
    if (object.mass_kg > 0) {
      names_.push_back(object.name);
      world_->streamed.push_back(body);
    }
  }
  poses_.resize(names_.size() * 12);
  read_poses();
}

Simulation::~Simulation() = default;

int64_t Simulation::sim_time_ns() const {
  return static_cast<int64_t>(std::llround(static_cast<double>(steps_) * 1e9 / rate_hz_));
}

void Simulation::step() {
  ++steps_;
  world_->arm->drive(joint_targets(static_cast<float>(static_cast<double>(steps_) / rate_hz_)));
  // No sub-steps: one call is one step, whatever the clock on the wall says.
  world_->dynamics.stepSimulation(world_->step_s, 0, world_->step_s);
  read_poses();
}

void Simulation::read_poses() {
  for (size_t i = 0; i < names_.size(); ++i) {
    const btTransform pose = i < kArmNames.size()
                                 ? world_->arm->stream_from_body(i)
                                 : world_->streamed[i - kArmNames.size()]->getWorldTransform();
    float* out = poses_.data() + i * 12;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) *out++ = static_cast<float>(pose.getBasis()[row][column]);
      *out++ = static_cast<float>(pose.getOrigin()[row]);
    }
  }
}

void PoseHash::add(const std::vector<float>& poses) {
  for (float value : poses) {
    uint32_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    value_ = (value_ ^ bits) * 0x100000001b3ull;
  }
}

}  // namespace bullet_arm
