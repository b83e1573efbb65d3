// The arm as a btMultiBody: turret, shoulder, elbow, wrist, roll and two sliding fingers, each with a
// position motor.
#pragma once

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <btBulletDynamicsCommon.h>

#include <memory>
#include <string>
#include <vector>

#include "examples/bullet_arm/arm_plan.h"

namespace bullet_arm {

// arm_base, arm_link_1 .. arm_link_5, finger_left, finger_right. The first stands still and is streamed all
// the same: a renderer may be given a scene where it rests elsewhere.
extern const std::vector<std::string> kArmNames;

class Arm {
 public:
  Arm(btMultiBodyDynamicsWorld& world, float step_s);
  ~Arm();
  Arm(const Arm&) = delete;
  Arm& operator=(const Arm&) = delete;

  void drive(const JointTargets& targets);
  // In the order of kArmNames; the origin of a link is its centre of mass, X points along it.
  btTransform stream_from_body(size_t index) const;

 private:
  void add_link(int link, const btVector3& half_extents);
  void place_colliders();

  btMultiBodyDynamicsWorld& world_;
  std::unique_ptr<btMultiBody> body_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders_;
  std::vector<std::unique_ptr<btMultiBodyJointMotor>> motors_;
};

}  // namespace bullet_arm
