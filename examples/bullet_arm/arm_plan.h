// Motion script of the arm: way points of the gripper in cylindrical coordinates about the base, and inverse
// kinematics. Metres, radians, seconds.
#pragma once

#include <array>

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

struct JointTargets {
  JointValues position{};
  JointValues velocity{};
};

constexpr float kScriptSeconds = 8.0f;

// Returns targets at a script time; after the end of the script the arm rests.
JointTargets joint_targets(float time_s);

}  // namespace bullet_arm
