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

// How far ahead contacts are kept, as a share of a body's size. More than Bullet's 0.02, because a block
// flies 1 cm in a step and is to be stopped at the floor, not below it; at 0.08 stale contacts begin to tip
// the stack of cans.
constexpr float kContactAhead = 0.05f;

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
