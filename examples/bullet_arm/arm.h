// Robot arm as a btMultiBody: turret, shoulder, elbow, wrist, roll and two sliding fingers, with a position
// motor per joint. SI units; Z up.
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

// arm_base, arm_link_1 .. arm_link_5, finger_left, finger_right. The base never moves but is streamed too,
// since a scene file may place it elsewhere.
extern const std::vector<std::string> kArmNames;

class Arm {
 public:
  Arm(btMultiBodyDynamicsWorld& world, float step_s);
  ~Arm();
  Arm(const Arm&) = delete;
  Arm& operator=(const Arm&) = delete;

  void drive(const JointTargets& targets);
  // index: as in kArmNames. A link's origin is its centre of mass; X points along the link.
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
