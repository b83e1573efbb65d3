#include "examples/bullet_arm/simulation.h"

#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "examples/bullet_arm/arm.h"

namespace bullet_arm {
namespace {

// Contact breaking threshold as a share of body size. Bullet's default of 0.02 is too small: a block moves 1
// cm per step and must stop at the floor, not below. From 0.08 on, stale contacts tip the stack of cans.
constexpr float kContactAhead = 0.05f;

}  // namespace

// Members are declared so that bodies are destroyed before the world.
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
    shapes.push_back(examples::make_shape(object));
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
      // Only rolling bodies have rolling friction. Bullet adds the values of both bodies, so that friction of
      // the floor would keep dominoes upright.
      body->setRollingFriction(0.0015f);
      body->setSpinningFriction(0.0015f);
    }
    // A moving multi-body does not wake a sleeping island reliably.
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
  // No sub-steps: each call is one step, independent of the wall clock.
  world_->dynamics.stepSimulation(world_->step_s, 0, world_->step_s);
  read_poses();
}

void Simulation::read_poses() {
  for (size_t i = 0; i < names_.size(); ++i) {
    const btTransform pose = i < kArmNames.size()
                                 ? world_->arm->stream_from_body(i)
                                 : world_->streamed[i - kArmNames.size()]->getWorldTransform();
    const std::array<float, 12> row_major = examples::pose_of(pose);
    std::copy(row_major.begin(), row_major.end(), poses_.begin() + static_cast<std::ptrdiff_t>(i * 12));
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
