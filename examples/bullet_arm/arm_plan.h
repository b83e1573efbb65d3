// What the arm is told to do: way points of the gripper in cylinder coordinates about the base, and the joint
// angles that bring it there.
#pragma once

#include <array>

namespace bullet_arm {

// Lengths of the arm, metres.
constexpr float kBaseHeight_m = 0.12f;
constexpr float kShoulderHeight_m = 0.34f;
constexpr float kUpperArm_m = 0.50f;
constexpr float kForearm_m = 0.44f;
constexpr float kWrist_m = 0.08f;  // wrist pitch axis to roll joint
constexpr float kPalm_m = 0.09f;   // roll joint to the fingers' root
constexpr float kFinger_m = 0.11f;
constexpr float kTool_m = 0.265f;  // wrist pitch axis to the point between the pads
constexpr float kFingerThickness_m = 0.018f;
constexpr float kFingerOpen_m = 0.052f;    // joint position of an open finger
constexpr float kFingerClosed_m = 0.020f;  // told to close on the held box, which stops the pads before

// turret, shoulder, elbow, wrist, roll, finger left, finger right: radians, the fingers metres
constexpr int kJoints = 7;
using JointValues = std::array<float, kJoints>;

struct JointTargets {
  JointValues position{};
  JointValues velocity{};
};

constexpr float kScriptSeconds = 8.0f;

// After the script's end the arm rests.
JointTargets joint_targets(float time_s);

}  // namespace bullet_arm
