#include "examples/bullet_arm/arm.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

#include "examples/bullet_arm/simulation.h"

namespace bullet_arm {

namespace {

struct WayPoint {
  float time_s;
  float azimuth_rad;
  float radius_m;
  float height_m;   // height of the point between the finger pads
  float pitch_rad;  // pitch of the gripper; -pi/2 points down
  float roll_rad;   // 0: the fingers open along the circle
  float finger_m;
};

constexpr float kDown = -1.5707963f;
constexpr float kRadial =
    1.5707963f;  // fingers open along the radius, so that the gripper pushes squarely along the circle
constexpr float kOpen = kFingerOpen_m, kShut = kFingerClosed_m, kFist = 0.006f;
constexpr float kGripHeight = kPlinthHeight_m + kHeldBoxHalf_m;
constexpr float kHeldAz = kHeldBoxAzimuth_rad, kDominoAz = kFirstDominoAzimuth_rad;

constexpr WayPoint kScript[] = {
    {0.00f, -1.5708f, 0.46f, 0.50f, -1.15f, 0, kOpen},
    {0.95f, kHeldAz, kHeldBoxRadius_m, 0.22f, kDown, kRadial, kOpen},
    {1.30f, kHeldAz, kHeldBoxRadius_m, kGripHeight, kDown, kRadial, kOpen},
    {1.55f, kHeldAz, kHeldBoxRadius_m, kGripHeight, kDown, kRadial, kShut},
    {1.95f, kHeldAz, kHeldBoxRadius_m, 0.24f, kDown, kRadial, kShut},
    // carry the box to the dominoes
    {2.50f, kDominoAz - 0.20f, kDominoRadius_m, 0.15f, kDown, kRadial, kShut},
    {2.60f, kDominoAz - 0.20f, kDominoRadius_m, 0.125f, kDown, kRadial, kShut},
    {2.95f, kDominoAz + 0.03f, kDominoRadius_m, 0.125f, kDown, kRadial, kShut},
    {3.30f, kDominoAz - 0.16f, 0.78f, 0.26f, kDown, kRadial, kShut},
    // drop the box
    {3.75f, -2.55f, 0.62f, 0.20f, kDown, kRadial, kShut},
    {3.90f, -2.55f, 0.62f, 0.20f, kDown, kRadial, kOpen},
    {4.20f, -2.62f, 0.58f, 0.24f, kDown, 0.4f, kOpen},
    // wind up and sweep
    {4.60f, -2.62f, 0.56f, 0.115f, kDown, 0, kFist},
    {6.35f, 0.22f, 0.58f, 0.125f, kDown, 0, kFist},
    {6.80f, 0.05f, 0.52f, 0.36f, -1.35f, 0, kFist},
    {7.70f, -1.5708f, 0.46f, 0.50f, -1.15f, 0, kOpen},
    {kScriptSeconds, -1.5708f, 0.46f, 0.50f, -1.15f, 0, kOpen},
};

// Minimum-jerk interpolation from rest to rest, t in [0, 1].
float minimum_jerk(float t) {
  return t * t * t * (10 + t * (-15 + 6 * t));
}

float mix(float a, float b, float t) {
  return a + (b - a) * t;
}

WayPoint way_point_at(float time_s) {
  const float t = std::clamp(time_s, 0.0f, kScriptSeconds);
  size_t i = 1;
  while (i + 1 < std::size(kScript) && kScript[i].time_s < t) ++i;
  const WayPoint& a = kScript[i - 1];
  const WayPoint& b = kScript[i];
  const float s = minimum_jerk((t - a.time_s) / (b.time_s - a.time_s));
  return {t,
          mix(a.azimuth_rad, b.azimuth_rad, s),
          mix(a.radius_m, b.radius_m, s),
          mix(a.height_m, b.height_m, s),
          mix(a.pitch_rad, b.pitch_rad, s),
          mix(a.roll_rad, b.roll_rad, s),
          mix(a.finger_m, b.finger_m, s)};
}

// Inverse kinematics of two links in the vertical plane of the azimuth, elbow up. The wrist compensates the
// pitch.
JointValues inverse_kinematics(const WayPoint& point) {
  const float x = point.radius_m - kTool_m * std::cos(point.pitch_rad);
  const float z = point.height_m - kTool_m * std::sin(point.pitch_rad) - kShoulderHeight_m;
  const float reach = std::sqrt(x * x + z * z);
  const float cos_elbow = std::clamp(
      (reach * reach - kUpperArm_m * kUpperArm_m - kForearm_m * kForearm_m) / (2 * kUpperArm_m * kForearm_m),
      -1.0f, 1.0f);
  const float bend = std::acos(cos_elbow);
  const float shoulder =
      std::atan2(z, x) + std::atan2(kForearm_m * std::sin(bend), kUpperArm_m + kForearm_m * cos_elbow);
  const float wrist = point.pitch_rad - shoulder + bend;
  return {point.azimuth_rad, shoulder, -bend, wrist, point.roll_rad, point.finger_m, point.finger_m};
}

}  // namespace

JointTargets joint_targets(float time_s) {
  constexpr float kHalfStep_s = 1.0f / 960.0f;
  JointTargets targets;
  targets.position = inverse_kinematics(way_point_at(time_s));
  const JointValues before = inverse_kinematics(way_point_at(time_s - kHalfStep_s));
  const JointValues after = inverse_kinematics(way_point_at(time_s + kHalfStep_s));
  for (size_t i = 0; i < targets.velocity.size(); ++i) {
    targets.velocity[i] = (after[i] - before[i]) / (2 * kHalfStep_s);
  }
  return targets;
}

namespace {

constexpr int kBase = -1;

// Motor limits: torques in N m, and forces in N for the fingers. Finger forces are low, since the fingers
// squeeze the held box.
constexpr JointValues kMotorLimit = {600, 600, 500, 250, 120, 45, 45};
constexpr float kPositionGain = 0.25f;  // share of the position error corrected per step

btVector3 box_inertia(float mass_kg, const btVector3& half) {
  const btVector3 s = half * half * (mass_kg / 3);
  return {s.y() + s.z(), s.x() + s.z(), s.x() + s.y()};
}

}  // namespace

const std::array<const char*, kJoints> kJointNames = {"turret", "shoulder",    "elbow",       "wrist",
                                                      "roll",   "finger_left", "finger_right"};

const std::vector<std::string> kArmNames = {"arm_base",   "arm_link_1", "arm_link_2",  "arm_link_3",
                                            "arm_link_4", "arm_link_5", "finger_left", "finger_right"};

Arm::Arm(btMultiBodyDynamicsWorld& world, float step_s) : world_(world) {
  const btQuaternion aligned = btQuaternion::getIdentity();
  const btVector3 up(0, 0, 1), lift(0, -1, 0), along(1, 0, 0);

  body_ = std::make_unique<btMultiBody>(kJoints, 0.0f, btVector3(0, 0, 0), true, false);
  body_->setBaseWorldTransform(btTransform(aligned, btVector3(0, 0, kBaseHeight_m / 2)));
  const btVector3 base_half(0.12f, 0.12f, kBaseHeight_m / 2);
  const btVector3 turret_half(0.085f, 0.085f, 0.10f), upper_half(kUpperArm_m / 2, 0.05f, 0.055f),
      forearm_half(kForearm_m / 2, 0.042f, 0.045f), wrist_half(kWrist_m / 2 + 0.02f, 0.036f, 0.036f),
      palm_half(kPalm_m / 2, 0.075f, 0.03f), finger_half(kFinger_m / 2, kFingerThickness_m / 2, 0.016f);

  const float shoulder_above_base = kShoulderHeight_m - kBaseHeight_m;
  body_->setupRevolute(0, 8, box_inertia(8, turret_half), kBase, aligned, up, {0, 0, kBaseHeight_m / 2},
                       {0, 0, shoulder_above_base / 2}, true);
  body_->setupRevolute(1, 5, box_inertia(5, upper_half), 0, aligned, lift, {0, 0, shoulder_above_base / 2},
                       {kUpperArm_m / 2, 0, 0}, true);
  body_->setupRevolute(2, 3.5f, box_inertia(3.5f, forearm_half), 1, aligned, lift, {kUpperArm_m / 2, 0, 0},
                       {kForearm_m / 2, 0, 0}, true);
  body_->setupRevolute(3, 1.2f, box_inertia(1.2f, wrist_half), 2, aligned, lift, {kForearm_m / 2, 0, 0},
                       {kWrist_m / 2, 0, 0}, true);
  body_->setupRevolute(4, 0.9f, box_inertia(0.9f, palm_half), 3, aligned, along, {kWrist_m / 2, 0, 0},
                       {kPalm_m / 2, 0, 0}, true);
  const btVector3 to_left(kPalm_m / 2, kFingerThickness_m / 2, 0),
      to_right(kPalm_m / 2, -kFingerThickness_m / 2, 0);
  body_->setupPrismatic(5, 0.2f, box_inertia(0.2f, finger_half), 4, aligned, {0, 1, 0}, to_left,
                        {kFinger_m / 2, 0, 0}, true);
  body_->setupPrismatic(6, 0.2f, box_inertia(0.2f, finger_half), 4, aligned, {0, -1, 0}, to_right,
                        {kFinger_m / 2, 0, 0}, true);
  body_->finalizeMultiDof();
  body_->setHasSelfCollision(false);
  body_->setCanSleep(false);
  body_->setLinearDamping(0.02f);
  body_->setAngularDamping(0.02f);

  const JointTargets start = joint_targets(0);
  for (int i = 0; i < kJoints; ++i) body_->setJointPos(i, start.position[static_cast<size_t>(i)]);
  world_.addMultiBody(body_.get());

  add_link(kBase, base_half);
  add_link(0, turret_half);
  add_link(1, upper_half);
  add_link(2, forearm_half);
  add_link(3, wrist_half);
  add_link(4, palm_half);
  add_link(5, finger_half);
  add_link(6, finger_half);
  place_colliders();

  for (int i = 0; i < kJoints; ++i) {
    const float limit = kMotorLimit[static_cast<size_t>(i)] * step_s;
    motors_.push_back(std::make_unique<btMultiBodyJointMotor>(body_.get(), i, 0.0f, limit));
    world_.addMultiBodyConstraint(motors_.back().get());
    motors_.back()->finalizeMultiDof();
  }
  drive(start);
}

Arm::~Arm() {
  for (auto& motor : motors_) world_.removeMultiBodyConstraint(motor.get());
  for (auto& collider : colliders_) world_.removeCollisionObject(collider.get());
  world_.removeMultiBody(body_.get());
}

void Arm::add_link(int link, const btVector3& half_extents) {
  shapes_.push_back(std::make_unique<btBoxShape>(half_extents));
  shapes_.back()->setMargin(0.002f);
  auto collider = std::make_unique<btMultiBodyLinkCollider>(body_.get(), link);
  collider->setCollisionShape(shapes_.back().get());
  const bool finger = link >= 5;
  collider->setFriction(finger ? 1.6f : 0.5f);
  if (link == kBase) {
    body_->setBaseCollider(collider.get());
    world_.addCollisionObject(collider.get(), btBroadphaseProxy::StaticFilter,
                              btBroadphaseProxy::AllFilter ^ btBroadphaseProxy::StaticFilter);
  } else {
    body_->getLink(link).m_collider = collider.get();
    world_.addCollisionObject(collider.get(), btBroadphaseProxy::DefaultFilter, btBroadphaseProxy::AllFilter);
  }
  colliders_.push_back(std::move(collider));
}

void Arm::place_colliders() {
  btAlignedObjectArray<btQuaternion> rotations;
  btAlignedObjectArray<btVector3> origins;
  body_->forwardKinematics(rotations, origins);
  body_->updateCollisionObjectWorldTransforms(rotations, origins);
}

void Arm::drive(const JointTargets& targets) {
  for (size_t i = 0; i < motors_.size(); ++i) {
    motors_[i]->setPositionTarget(targets.position[i], kPositionGain);
    motors_[i]->setVelocityTarget(targets.velocity[i], 1.0f);
  }
}

JointValues Arm::positions() const {
  JointValues values{};
  for (int joint = 0; joint < kJoints; ++joint)
    values[static_cast<size_t>(joint)] = body_->getJointPos(joint);
  return values;
}

JointValues Arm::velocities() const {
  JointValues values{};
  for (int joint = 0; joint < kJoints; ++joint)
    values[static_cast<size_t>(joint)] = body_->getJointVel(joint);
  return values;
}

btTransform Arm::stream_from_body(size_t index) const {
  return colliders_[index]->getWorldTransform();
}

}  // namespace bullet_arm
