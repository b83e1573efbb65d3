#include "examples/bullet_arm/arm_plan.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

#include "examples/bullet_arm/layout.h"

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

}  // namespace bullet_arm
