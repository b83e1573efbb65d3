// Robot arm and its motion script. The arm is a btMultiBody: turret, shoulder, elbow, wrist, roll and two
// sliding fingers, with a position motor per joint. SI units, radians; Z up.
#pragma once

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <btBulletDynamicsCommon.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace bullet_arm {

// Dimensions of the arm, metres.
constexpr float kBaseHeight_m = 0.12f;
constexpr float kShoulderHeight_m = 0.34f;
constexpr float kUpperArm_m = 0.50f;
constexpr float kForearm_m = 0.44f;
constexpr float kWrist_m = 0.08f;  // wrist pitch axis to roll joint
constexpr float kPalm_m = 0.09f;   // roll joint to finger base
constexpr float kFinger_m = 0.11f;
constexpr float kTool_m = 0.265f;  // wrist pitch axis to the point between the finger pads
constexpr float kFingerThickness_m = 0.018f;
constexpr float kFingerOpen_m = 0.052f;    // joint position of an open finger
constexpr float kFingerClosed_m = 0.020f;  // target of a closed finger; the held box stops the pads earlier

// Order: turret, shoulder, elbow, wrist, roll, left finger, right finger. Radians; metres for the fingers.
constexpr int kJoints = 7;
using JointValues = std::array<float, kJoints>;

extern const std::array<const char*, kJoints> kJointNames;
constexpr int kFirstFinger = 5;  // fingers slide, other joints turn

struct JointTargets {
  JointValues position{};
  JointValues velocity{};
};

constexpr float kScriptSeconds = 8.0f;

// Motion script: way points of the gripper in cylindrical coordinates about the base, with inverse
// kinematics. Returns targets at a script time; after the end of the script the arm rests.
JointTargets joint_targets(float time_s);

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
  JointValues positions() const;
  JointValues velocities() const;  // per second

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
