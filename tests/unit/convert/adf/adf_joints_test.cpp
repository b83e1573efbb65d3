// Test of the joints of AMBF models: their positions are those that Bullet measures between the bodies, with
// the frames that AMBF gives its constraints.
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>
#include <string>

#include "convert/glb/write_glb.h"
#include "convert/readers.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/protocol/robot/robot_handle.h"

namespace fire3dv::convert {
namespace {

using test::Pose12;
using test::RobotHandle;

struct Vec {
  double x, y, z;
  btVector3 bt() const { return {btScalar(x), btScalar(y), btScalar(z)}; }
  std::string yaml() const {
    std::ostringstream text;
    text.precision(17);
    text << "{x: " << x << ", y: " << y << ", z: " << z << "}";
    return text.str();
  }
};

std::string body(const std::string& id, const Vec& at, const Vec& rpy, double scale = 1) {
  return id + ":\n  name: " + id +
         "\n  mesh: ''\n  shape: BOX\n  geometry: {x: 1, y: 1, z: 1}\n  scale: " + std::to_string(scale) +
         "\n  location:\n    position: " + at.yaml() + "\n    orientation: {r: " + std::to_string(rpy.x) +
         ", p: " + std::to_string(rpy.y) + ", y: " + std::to_string(rpy.z) + "}\n";
}

struct JointBlock {
  std::string type;
  Vec parent_pivot, child_pivot, parent_axis, child_axis;
  double offset;

  std::string yaml(const std::string& name, const std::string& parent, const std::string& child) const {
    std::ostringstream text;
    text.precision(17);
    text << name << ":\n  name: " << name << "\n  parent: " << parent << "\n  child: " << child
         << "\n  type: " << type << "\n  parent pivot: " << parent_pivot.yaml()
         << "\n  child pivot: " << child_pivot.yaml() << "\n  parent axis: " << parent_axis.yaml()
         << "\n  child axis: " << child_axis.yaml() << "\n  offset: " << offset
         << "\n  joint limits: {low: -1.5, high: 1.25}\n";
    return text.str();
  }
};

class RobotAdf : public testing::Test {
 protected:
  Model read(const std::string& text) {
    Result<Model> model = read_adf(folder_.write("model.yaml", std::string_view(text)), {});
    EXPECT_TRUE(model.ok()) << model.error().message;
    return model ? std::move(*model) : Model();
  }
  static std::vector<std::byte> glb(const Model& model) {
    const auto written = write_glb(model);
    EXPECT_TRUE(written.ok());
    return written ? *written : std::vector<std::byte>();
  }
  static bool warns(const Model& model, const std::string& part) {
    return std::any_of(model.warnings.begin(), model.warnings.end(),
                       [&](const std::string& warning) { return warning.find(part) != std::string::npos; });
  }
  test::ScratchFolder folder_;
};

btTransform transform(const Pose12& p) {
  const auto f = [&](size_t i) { return btScalar(p[i]); };
  return btTransform{btMatrix3x3(f(0), f(1), f(2), f(4), f(5), f(6), f(8), f(9), f(10)),
                     btVector3(f(3), f(7), f(11))};
}

btQuaternion between(const btVector3& from, const btVector3& to) {
  return {from.cross(to).normalized(), from.angle(to)};
}

// Constraint frames as AMBF computes them, without the joint's own offset.
std::pair<btTransform, btTransform> frames(const JointBlock& joint, const btVector3& default_axis) {
  const btVector3 a = joint.parent_axis.bt().normalized(), b = joint.child_axis.bt().normalized();
  const btQuaternion joint_in_parent = between(default_axis, a), child_in_parent = between(b, a),
                     offset(a, btScalar(joint.offset));
  return {
      btTransform(joint_in_parent, joint.parent_pivot.bt()),
      btTransform(child_in_parent.inverse() * offset.inverse() * joint_in_parent, joint.child_pivot.bt())};
}

TEST_F(RobotAdf, PositionsMatchBullet) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto vec = [&] { return Vec{number(random), number(random), number(random)}; };
  for (const std::string type : {"revolute", "prismatic"})
    for (int run = 0; run < 20; ++run) {
      const JointBlock joint{type, vec(), vec(), vec(), vec(), number(random)};
      const Model model =
          read("bodies: [BODY a, BODY b]\njoints: [JOINT j]\n" + body("BODY a", vec(), vec()) +
               body("BODY b", vec(), vec()) + joint.yaml("JOINT j", "BODY a", "BODY b"));
      RobotHandle robot(glb(model));
      ASSERT_EQ(robot.joint_names(), std::vector<std::string>{"JOINT j"});
      EXPECT_EQ(robot.joint(0).lower, -1.5);
      const double position = number(random);
      robot.set({position});
      const btTransform a = transform(robot.pose("BODY a")), b = transform(robot.pose("BODY b"));
      const btRigidBody::btRigidBodyConstructionInfo info(1, nullptr, nullptr);
      btRigidBody parent(info), child(info);
      parent.setCenterOfMassTransform(a);
      child.setCenterOfMassTransform(b);
      if (type == "revolute") {
        const auto [in_a, in_b] = frames(joint, {0, 0, 1});
        btHingeConstraint hinge(parent, child, in_a, in_b, true);
        EXPECT_NEAR(hinge.getHingeAngle(a, b), position, 1e-5) << run;
        EXPECT_LT(((a * in_a).getOrigin() - (b * in_b).getOrigin()).length(), 1e-5) << run;
        EXPECT_GT((a * in_a).getBasis().getColumn(2).dot((b * in_b).getBasis().getColumn(2)), 1 - 1e-5)
            << run;
      } else {
        const auto [in_a, in_b] = frames(joint, {1, 0, 0});
        btSliderConstraint slider(parent, child, in_a, in_b, true);
        slider.calculateTransforms(a, b);
        slider.testLinLimits();
        EXPECT_NEAR(slider.getLinearPos(), position, 1e-5) << run;
        for (int column = 0; column < 3; ++column)
          EXPECT_GT((a * in_a).getBasis().getColumn(column).dot((b * in_b).getBasis().getColumn(column)),
                    1 - 1e-5);
      }
    }
}

TEST_F(RobotAdf, BeginsWithPoseOfFile) {
  // b hangs 0.4 rad turned on the end of a, whose pivot is scaled: 2 * (0, 0, 1).
  const double angle = 0.4;
  const Vec at{1, 2, 5};
  const JointBlock joint{"hinge", {0, 0, 1}, {0, 0, 0}, {0, 0, 1}, {0, 0, 1}, 0};
  const Model model = read("bodies: [BODY a, BODY b, BODY alone]\njoints: [JOINT j]\n" +
                           body("BODY a", {1, 2, 3}, {0, 0, 0}, 2) + body("BODY b", at, {0, 0, angle}) +
                           body("BODY alone", at, {0, 0, 0}) + joint.yaml("JOINT j", "BODY a", "BODY b"));
  ASSERT_EQ(model.kinematics.bodies.size(), 2u);
  RobotHandle robot(glb(model));
  ASSERT_EQ(robot.positions().size(), 1u);
  EXPECT_NEAR(robot.positions()[0], angle, 1e-12);
  EXPECT_NEAR(robot.pose("BODY b")[3], at.x, 1e-12);
  EXPECT_NEAR(robot.pose("BODY b")[11], at.z, 1e-12);
  EXPECT_NEAR(robot.pose("BODY b")[4], std::sin(angle), 1e-12);
}

TEST_F(RobotAdf, UnsupportedJointsAreReported) {
  const JointBlock ball{"p2p", {0, 0, 1}, {0, 0, -1}, {0, 0, 1}, {0, 0, 1}, 0};
  const auto with = [&](const char* type) {
    JointBlock joint = ball;
    joint.type = type;
    return joint;
  };
  std::string text = "bodies: [A, B, C, D]\njoints: [p, f, s, loop, again, lost, odd]\n";
  for (const char* id : {"A", "B", "C", "D"}) text += body(id, {1, 0, 0}, {0, 0, 0.5});
  text += ball.yaml("p", "A", "B") + with("fixed").yaml("f", "B", "C") + with("six dof").yaml("s", "C", "D") +
          ball.yaml("loop", "D", "A") + ball.yaml("again", "A", "C") + ball.yaml("lost", "A", "nobody") +
          with("screw").yaml("odd", "A", "B");
  const Model model = read(text);
  EXPECT_TRUE(warns(model, "joint \"loop\" is left out: its bodies form a loop"));
  EXPECT_TRUE(warns(model, "joint \"again\" is left out: \"C\" hangs on another joint already"));
  EXPECT_TRUE(warns(model, "joint \"lost\" is left out: there is no body \"nobody\""));
  EXPECT_TRUE(warns(model, "unknown type \"screw\""));
  RobotHandle robot(glb(model));
  EXPECT_EQ(robot.joint_names(), (std::vector<std::string>{"p", "f", "s"}));
  EXPECT_EQ(robot.joint(0).type, FIRE3DV_JOINT_BALL);
  EXPECT_EQ(robot.joint(1).type, FIRE3DV_JOINT_FIXED);
  EXPECT_EQ(robot.joint(2).type, FIRE3DV_JOINT_FLOATING);
  // The pivots of a ball joint coincide: (0, 0, 1) of A is (0, 0, -1) of B.
  const Pose12 a = robot.pose("A"), b = robot.pose("B");
  for (size_t row = 0; row < 3; ++row)
    EXPECT_NEAR(a[4 * row + 2] + a[4 * row + 3], -b[4 * row + 2] + b[4 * row + 3], 1e-12);
}

}  // namespace
}  // namespace fire3dv::convert
