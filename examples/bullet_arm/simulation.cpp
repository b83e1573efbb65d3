#include "examples/bullet_arm/simulation.h"

#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "examples/bullet_arm/arm.h"
#include "examples/common/object.h"

namespace bullet_arm {

namespace {

using examples::Random;

constexpr std::array<const char*, 6> kPlastics = {"plastic_red",   "plastic_blue", "plastic_yellow",
                                                  "plastic_green", "plastic_teal", "plastic_violet"};
constexpr int kHues = 12;  // domino_hue_00 .. domino_hue_11

std::string numbered(const char* prefix, int number, const char* format = "%s_%03d") {
  char text[64];
  std::snprintf(text, sizeof text, format, prefix, number);
  return text;
}

// Frame at an azimuth and radius: X points outwards, Y along the circle, counter-clockwise.
btTransform polar(float azimuth_rad, float radius_m, float z_m, float turn_rad = 0) {
  return btTransform(btQuaternion(btVector3(0, 0, 1), azimuth_rad + turn_rad),
                     btVector3(radius_m * std::cos(azimuth_rad), radius_m * std::sin(azimuth_rad), z_m));
}

btTransform offset(const btTransform& frame, float x, float y, float z, float turn_rad = 0) {
  return frame * btTransform(btQuaternion(btVector3(0, 0, 1), turn_rad), btVector3(x, y, z));
}

class Builder {
 public:
  explicit Builder(uint64_t seed) : random_(seed) {}

  void held_box() {
    objects_.push_back({"plinth_pick",
                        Shape::cylinder,
                        {0.09f, 0, kPlinthHeight_m / 2},
                        0,
                        "dark_metal",
                        polar(kHeldBoxAzimuth_rad, kHeldBoxRadius_m, kPlinthHeight_m / 2)});
    add_box(kHeldBoxHalf_m, 0.15f, "plastic_red",
            polar(kHeldBoxAzimuth_rad, kHeldBoxRadius_m, kPlinthHeight_m + kHeldBoxHalf_m));
  }

  // Wall of boxes along the circle: 5 + 4 + 3 + 2 + 1.
  void box_wall() {
    const float half = 0.031f, pitch = 0.068f;
    const btTransform frame = polar(-1.98f, 0.57f, 0);
    for (int row = 0; row < 5; ++row) {
      for (int column = 0; column < 5 - row; ++column) {
        const float y = (static_cast<float>(column) - static_cast<float>(4 - row) / 2) * pitch;
        const float z = half + static_cast<float>(row) * 2 * half;
        const auto color = static_cast<size_t>(row * 2 + column) % kPlastics.size();
        add_box(half, 0.12f, kPlastics[color], offset(frame, jitter(), y + jitter(), z, 20 * jitter()));
      }
    }
  }

  // Tower of three blocks per layer, alternately rotated, with a copper ball on top.
  void block_tower() {
    const Size half{0.078f, 0.0255f, 0.018f};
    const float plinth = 0.04f;
    const int layers = 10;
    const btTransform frame = polar(-0.92f, 0.57f, 0, 0.3f);
    objects_.push_back({"plinth_tower",
                        Shape::box,
                        {0.12f, 0.12f, plinth / 2},
                        0,
                        "dark_metal",
                        offset(frame, 0, 0, plinth / 2)});
    int number = 0;
    for (int layer = 0; layer < layers; ++layer) {
      const float turn = layer % 2 == 0 ? 0.0f : 1.5707963f;
      const float z = plinth + half.z + static_cast<float>(layer) * 2 * half.z;
      for (int column = -1; column <= 1; ++column) {
        const btTransform turned = offset(frame, 0, 0, z, turn + 4 * jitter());
        add(numbered("block", number++), Shape::box, half, 0.11f, layer % 3 == 2 ? "wood_dark" : "wood",
            offset(turned, jitter(), static_cast<float>(column) * 0.052f, 0));
      }
    }
    add_sphere(0.036f, 0.3f, "copper",
               offset(frame, 0, 0, plinth + static_cast<float>(layers) * 2 * half.z + 0.036f));
  }

  // Wall of cans, 4 + 3 + 2 + 1, with planks between the rows.
  void can_wall() {
    const float radius = 0.033f, half = 0.042f, pitch = 0.07f, plank = 0.008f;
    const btTransform frame = polar(-0.12f, 0.6f, 0);
    int number = 0;
    for (int row = 0; row < 4; ++row) {
      const float bottom = static_cast<float>(row) * 2 * (half + plank);
      for (int column = 0; column < 4 - row; ++column) {
        const float y = (static_cast<float>(column) - static_cast<float>(3 - row) / 2) * pitch;
        add(numbered("can", number++), Shape::cylinder, {radius, 0, half}, 0.1f,
            row % 2 == 0 ? "plastic_red" : "painted_teal",
            offset(frame, jitter(), y + jitter(), bottom + half, 300 * jitter()));
      }
      if (row == 3) break;
      const Size size{0.04f, static_cast<float>(4 - row) * pitch / 2, plank};
      add(numbered("plank", row, "%s_%02d"), Shape::box, size, 0.12f, "wood",
          offset(frame, jitter(), jitter(), bottom + 2 * half + plank, 4 * jitter()));
    }
  }

  void domino_row() {
    const Size half{0.034f, 0.009f, 0.07f};
    const int count = 36;
    for (int i = 0; i < count; ++i) {
      const float azimuth = kFirstDominoAzimuth_rad + static_cast<float>(i) * 0.0535f;
      const int hue = i * kHues / count;
      add(numbered("domino", i, "%s_%02d"), Shape::box, half, 0.06f, numbered("domino_hue", hue, "%s_%02d"),
          polar(azimuth, kDominoRadius_m + jitter(), half.z, 15 * jitter()));
    }
    // Golden ball that the last domino hits.
    const float after = kFirstDominoAzimuth_rad + (static_cast<float>(count) + 1.0f) * 0.0535f;
    add_sphere(0.045f, 0.25f, "gold", polar(after, kDominoRadius_m, 0.045f));
  }

  void loose_things() {
    const std::array<const char*, 7> materials = {"gold",   "copper",      "plastic_blue", "chrome",
                                                  "copper", "plastic_red", "gold"};
    for (size_t i = 0; i < materials.size(); ++i) {
      const float radius = random_.uniform(0.022f, 0.036f);
      const float azimuth = -2.4f + static_cast<float>(i) * 0.33f + random_.uniform(-0.05f, 0.05f);
      add_sphere(radius, 900 * radius * radius * radius * 4, materials[i],
                 polar(azimuth, random_.uniform(0.34f, 0.41f), radius));
    }
    for (int i = 0; i < 8; ++i) {
      const float radius = 0.024f, half = 0.03f;
      const float azimuth = -1.62f + static_cast<float>(i % 4) * 0.1f + random_.uniform(-0.01f, 0.01f);
      const float distance = i < 4 ? 0.52f : 0.66f;
      const btTransform lying = polar(azimuth, distance + random_.uniform(-0.01f, 0.01f), radius) *
                                btTransform(btQuaternion(btVector3(0, 1, 0), 1.5707963f));
      add(numbered("capsule", i, "%s_%02d"), Shape::capsule, {radius, 0, half}, 0.1f,
          kPlastics[static_cast<size_t>(i + 1) % kPlastics.size()], lying);
    }
  }

  std::vector<Object> take() { return std::move(objects_); }

 private:
  // Position noise: perfect symmetry makes falling bodies look artificial.
  float jitter() { return random_.uniform(-0.0012f, 0.0012f); }

  void add(std::string name, Shape shape, Size size, float mass_kg, std::string material,
           const btTransform& pose) {
    objects_.push_back({std::move(name), shape, size, mass_kg, std::move(material), pose});
  }
  void add_box(float half, float mass_kg, const char* material, const btTransform& pose) {
    add(numbered("box", boxes_++), Shape::box, {half, half, half}, mass_kg, material, pose);
  }
  void add_sphere(float radius, float mass_kg, const char* material, const btTransform& pose) {
    add(numbered("sphere", spheres_++, "%s_%02d"), Shape::sphere, {radius, 0, 0}, mass_kg, material, pose);
  }

  Random random_;
  std::vector<Object> objects_;
  int boxes_ = 0;
  int spheres_ = 0;
};

}  // namespace

std::vector<Object> make_layout(uint64_t seed) {
  Builder builder(seed);
  builder.held_box();
  builder.box_wall();
  builder.block_tower();
  builder.can_wall();
  builder.domino_row();
  builder.loose_things();
  return builder.take();
}

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

std::vector<std::array<float, 3>> Simulation::contact_points() const {
  std::vector<std::array<float, 3>> points;
  const btDispatcher& dispatcher = world_->dispatcher;
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *world_->dispatcher.getManifoldByIndexInternal(i);
    for (int j = 0; j < manifold.getNumContacts(); ++j) {
      const btManifoldPoint& point = manifold.getContactPoint(j);
      if (!(point.getAppliedImpulse() > 0)) continue;  // Bullet keeps points of bodies that are near, too
      const btVector3& place = point.getPositionWorldOnB();
      points.push_back({place.x(), place.y(), place.z()});
    }
  }
  return points;
}

std::vector<JointState> Simulation::joints() const {
  const JointValues positions = world_->arm->positions(), velocities = world_->arm->velocities();
  std::vector<JointState> joints;
  for (size_t i = 0; i < kJointNames.size(); ++i)
    joints.push_back({kJointNames[i], i >= kFirstFinger, positions[i], velocities[i]});
  return joints;
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
