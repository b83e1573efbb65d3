#include "examples/bullet_arm/arm.h"

namespace bullet_arm {
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

btTransform Arm::stream_from_body(size_t index) const {
  return colliders_[index]->getWorldTransform();
}

}  // namespace bullet_arm
