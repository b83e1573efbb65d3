// Test of forward kinematics in the client: each type of joint against its closed form, mimic, limits, base,
// scales.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "fire3dv/client.h"
#include "tests/unit/protocol/robot/robot_handle.h"

namespace fire3dv::test {
namespace {

constexpr double kPi = std::numbers::pi, kTolerance = 1e-14;

// Robot of the bodies and joints, whose root node is scaled and turned by `root`.
std::string scene(const std::string& bodies, const std::string& joints, const std::string& root = "",
                  const std::string& link = "") {
  return R"({"asset":{"version":"2.0"},"nodes":[{"name":"robot",)" + root +
         R"("children":[1,2,3],"extras":{"fire3dv":{"robot":{"version":1,"bodies":[)" + bodies +
         R"(],"joints":[)" + joints + R"(]}}}},{"name":"a")" + link + R"(},{"name":"b"},{"name":"c"}]})";
}

TEST(Robot, TwoRevoluteJointsInAPlane) {
  RobotHandle robot(
      scene(R"({"node":"a","translation":[0,0,1]},{"node":"b","parent":"a","translation":[2,0,0]},
      {"node":"c","parent":"b","translation":[3,0,0]})",
            R"({"name":"j1","type":"revolute","node":"a","axis":[0,0,1]},
      {"name":"j2","type":"revolute","node":"b","axis":[0,0,5]})"));
  EXPECT_EQ(fire3dv_position_count(robot.get()), 2u);
  const double s = 0.3, e = -1.2;
  robot.set({s, e});
  expect_near(robot.pose("c"),
              {std::cos(s + e), -std::sin(s + e), 0, 2 * std::cos(s) + 3 * std::cos(s + e),  //
               std::sin(s + e), std::cos(s + e), 0, 2 * std::sin(s) + 3 * std::sin(s + e),   //
               0, 0, 1, 1},
              kTolerance, "end");
}

TEST(Robot, AnchorAndReferenceOfRevoluteJoint) {
  // A door: its hinge is at (1, 0, 0) of the body, and it is not displaced at 0.5.
  RobotHandle robot(scene(R"({"node":"a","translation":[5,0,0]})",
                          R"({"name":"hinge","type":"revolute","node":"a","axis":[0,0,1],"anchor":[1,0,0],
      "reference":0.5})"));
  EXPECT_EQ(robot.positions(), std::vector<double>{0.5});
  expect_near(robot.pose("a"), {1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0}, kTolerance, "at the reference");
  robot.set({0.5 + kPi / 2});  // the body's origin goes from (-1, 0) to (0, -1) about the hinge
  expect_near(robot.pose("a"), {0, -1, 0, 6, 1, 0, 0, -1, 0, 0, 1, 0}, kTolerance, "quarter turn");
}

TEST(Robot, PrismaticJointOnAnObliqueAxis) {
  RobotHandle robot(scene(R"({"node":"a","rotation":[0,0,0.7071067811865476,0.7071067811865476]})",
                          R"({"name":"slide","type":"prismatic","node":"a","axis":[3,0,4],"reference":-1})"));
  robot.set({1.5});  // 2.5 along (3, 0, 4) / 5 of the body, whose X is the world's Y
  expect_near(robot.pose("a"), {0, -1, 0, 0, 1, 0, 0, 1.5, 0, 0, 1, 2}, 1e-14, "slide");
}

TEST(Robot, PlanarJoint) {
  RobotHandle upright(scene(R"({"node":"a"})", R"({"name":"p","type":"planar","node":"a","axis":[0,0,1]})"));
  upright.set({2, 3, kPi / 2});
  expect_near(upright.pose("a"), {0, -1, 0, 2, 1, 0, 0, 3, 0, 0, 1, 0}, kTolerance, "normal Z");
  // The shortest rotation from Z to X turns X to -Z and keeps Y.
  RobotHandle lying(scene(R"({"node":"a"})", R"({"name":"p","type":"planar","node":"a","axis":[1,0,0]})"));
  lying.set({2, 3, kPi / 2});
  expect_near(lying.pose("a"), {1, 0, 0, 0, 0, 0, -1, 3, 0, 1, 0, -2}, kTolerance, "normal X");
  RobotHandle down(scene(R"({"node":"a"})", R"({"name":"p","type":"planar","node":"a","axis":[0,0,-1]})"));
  down.set({2, 3, 0});
  expect_near(down.pose("a"), {1, 0, 0, 2, 0, 1, 0, -3, 0, 0, 1, 0}, kTolerance, "normal -Z");
}

TEST(Robot, BallAndFloatingJoints) {
  const double h = std::numbers::sqrt2 / 2;
  RobotHandle robot(scene(R"({"node":"a"},{"node":"b","parent":"a","translation":[0,0,2]})",
                          R"({"name":"free","type":"floating","node":"a","initial":[1,2,3,0,0,0,1]},
      {"name":"ball","type":"ball","node":"b","anchor":[0,0,-2]})"));
  EXPECT_EQ(robot.positions(), (std::vector<double>{1, 2, 3, 0, 0, 0, 1, 0, 0, 0, 1}));
  // A quaternion that is no unit quaternion is normalised.
  robot.set({4, 5, 6, 0, 0, 3, 3, h, 0, 0, h});
  expect_near(robot.pose("a"), {0, -1, 0, 4, 1, 0, 0, 5, 0, 0, 1, 6}, kTolerance, "free");
  // b turns a quarter about X at the origin of a: its own origin goes from (0, 0, 2) to (0, -2, 0) of a.
  expect_near(robot.pose("b"), {0, 0, 1, 4 + 2, 1, 0, 0, 5, 0, 1, 0, 6}, kTolerance, "ball");
  robot.set({4, 5, 6, 1, 0, 0, 1, 1, 1, 0, 0}, FIRE3DV_POSITIONS_WXYZ);
  expect_near(robot.pose("b"), {0, 0, 1, 4 + 2, 1, 0, 0, 5, 0, 1, 0, 6}, kTolerance, "w x y z");
  EXPECT_NEAR(robot.positions()[5], h, kTolerance);
}

TEST(Robot, JointsApplyInOrder) {
  RobotHandle robot(scene(R"({"node":"a"})", R"({"name":"turn","type":"revolute","node":"a","axis":[0,0,1]},
      {"name":"slide","type":"prismatic","node":"a","axis":[1,0,0]})"));
  robot.set({kPi / 2, 3});  // the slide's axis has turned with the body
  expect_near(robot.pose("a"), {0, -1, 0, 0, 1, 0, 0, 3, 0, 0, 1, 0}, kTolerance, "turn, then slide");
}

const char* const kMimicBodies = R"({"node":"a"},{"node":"b"},{"node":"c"})";
// b = 2 a + 1, c = -3 b + 0.5; the last one stands before what it follows.
const char* const kMimicJoints = R"({"name":"c","type":"prismatic","node":"c","axis":[1,0,0],
    "mimic":{"joint":"b","multiplier":-3,"offset":0.5}},
  {"name":"a","type":"revolute","node":"a","axis":[0,0,1],"limits":[-1,1]},
  {"name":"b","type":"prismatic","node":"b","axis":[1,0,0],"mimic":{"joint":"a","multiplier":2,"offset":1}})";

TEST(Robot, JointsFollowOthersOverOthers) {
  RobotHandle robot(scene(kMimicBodies, kMimicJoints));
  ASSERT_EQ(fire3dv_position_count(robot.get()), 1u);
  robot.set({0.25});
  EXPECT_NEAR(robot.pose("b")[3], 1.5, kTolerance);
  EXPECT_NEAR(robot.pose("c")[3], -4, kTolerance);
  EXPECT_EQ(robot.joint(0).followed_joint, 2);
  EXPECT_EQ(robot.joint(0).multiplier, -3);
  EXPECT_EQ(robot.joint(0).position_count, 0u);
  EXPECT_EQ(robot.joint(1).followed_joint, -1);
  const double one = 1;
  EXPECT_EQ(fire3dv_set_joint(robot.get(), 0, &one, 1, 0), FIRE3DV_ERROR_ARGUMENT);
  EXPECT_STREQ(fire3dv_last_error(),
               "joint \"c\" follows \"a\": set that one, or open the robot without mimic");

  RobotHandle independent(scene(kMimicBodies, kMimicJoints), FIRE3DV_ROBOT_NO_MIMIC);
  independent.set({7, 0, 8});
  EXPECT_NEAR(independent.pose("b")[3], 8, kTolerance);
  EXPECT_NEAR(independent.pose("c")[3], 7, kTolerance);
}

TEST(Robot, LimitsClampOnRequestOnly) {
  RobotHandle robot(scene(kMimicBodies, kMimicJoints));
  EXPECT_EQ(robot.joint(1).has_limits, 1);
  EXPECT_EQ(robot.joint(1).lower, -1);
  EXPECT_EQ(robot.joint(1).upper, 1);
  EXPECT_EQ(robot.joint(0).has_limits, 0);
  robot.set({5});
  EXPECT_EQ(robot.positions(), std::vector<double>{5});
  robot.set({5}, FIRE3DV_POSITIONS_CLAMP);
  EXPECT_EQ(robot.positions(), std::vector<double>{1});
  robot.set({-5}, FIRE3DV_POSITIONS_CLAMP);
  EXPECT_EQ(robot.positions(), std::vector<double>{-1});
}

TEST(Robot, WrongPositionsChangeNothing) {
  RobotHandle robot(scene(R"({"node":"a"},{"node":"b"})", R"({"name":"r","type":"revolute","node":"a"},
      {"name":"ball","type":"ball","node":"b"},{"name":"fast","type":"fixed","node":"b"})"));
  const std::vector<double> before = robot.positions();
  const auto refuse = [&](const std::vector<double>& positions, const std::string& sentence) {
    EXPECT_EQ(fire3dv_set_positions(robot.get(), positions.data(), positions.size(), 0),
              FIRE3DV_ERROR_ARGUMENT);
    EXPECT_EQ(fire3dv_last_error(), sentence);
    EXPECT_EQ(robot.positions(), before);
  };
  refuse({1, 0, 0, 0}, "there are 4 positions; the robot has 5");
  refuse({1, 0, 0, 0, 0},
         "the position of joint \"ball\" has a quaternion without length; a unit quaternion is needed");
  refuse({1, 0, std::numeric_limits<double>::infinity(), 0, 1},
         "the position of joint \"ball\" is not finite");
  refuse({std::nan(""), 0, 0, 0, 1}, "the position of joint \"r\" is not finite");
  EXPECT_EQ(fire3dv_set_joint(robot.get(), 2, nullptr, 0, 0), FIRE3DV_ERROR_ARGUMENT);
  EXPECT_STREQ(fire3dv_last_error(), "joint \"fast\" is fixed; it has no position");
  EXPECT_EQ(fire3dv_set_joint(robot.get(), 3, nullptr, 0, 0), FIRE3DV_ERROR_ARGUMENT);
  EXPECT_EQ(fire3dv_set_positions(robot.get(), before.data(), before.size(), 4), FIRE3DV_ERROR_ARGUMENT);
  EXPECT_EQ(fire3dv_set_positions(nullptr, before.data(), before.size(), 0), FIRE3DV_ERROR_ARGUMENT);
  Pose12 pose{};
  EXPECT_EQ(fire3dv_get_node_pose(robot.get(), "nobody", pose.data()), FIRE3DV_ERROR_ARGUMENT);
  EXPECT_STREQ(fire3dv_last_error(), "the robot has no body \"nobody\"");
}

TEST(Robot, BaseMovesAllBodies) {
  RobotHandle robot(
      scene(R"({"node":"a","translation":[1,0,0]})", R"({"name":"r","type":"revolute","node":"a"})"));
  const Pose12 base{0, -1, 0, 10, 1, 0, 0, 20, 0, 0, 1, 30};
  ASSERT_EQ(fire3dv_set_base(robot.get(), base.data()), FIRE3DV_OK);
  expect_near(robot.pose("a"), {0, -1, 0, 10, 1, 0, 0, 21, 0, 0, 1, 30}, kTolerance, "based");
  Pose12 wrong = base;
  wrong[7] = std::nan("");
  EXPECT_EQ(fire3dv_set_base(robot.get(), wrong.data()), FIRE3DV_ERROR_ARGUMENT);
  ASSERT_EQ(fire3dv_set_base(robot.get(), nullptr), FIRE3DV_OK);
  expect_near(robot.pose("a"), {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0}, kTolerance, "without a base");
}

TEST(Robot, DescriptionHasSceneFrame) {
  // The root turns Z up to Y up and makes metres of millimetres; node a has a scale of its own, one side of
  // it 0.
  const std::string root =
      R"("rotation":[-0.7071067811865476,0,0,0.7071067811865476],"scale":[0.001,0.001,0.001],"translation":[7,8,9],)";
  RobotHandle robot(scene(R"({"node":"a","translation":[0,0,500]},{"node":"gone"},{"node":"b"})",
                          R"({"name":"r","type":"revolute","node":"a"})", root, R"(,"scale":[2,0,1])"));
  fire3dv_description description{};
  description.struct_size = sizeof description;
  ASSERT_EQ(fire3dv_get_robot_description(robot.get(), &description), FIRE3DV_OK);
  ASSERT_EQ(description.node_count, 2u);  // the scene has no node "gone"
  EXPECT_STREQ(description.node_names[0], "a");
  EXPECT_STREQ(description.node_names[1], "b");
  Pose12 world{};
  std::copy(description.world_from_stream, description.world_from_stream + 12, world.begin());
  expect_near(world, {0.001, 0, 0, 7, 0, 0, 0.001, 8, 0, -0.001, 0, 9}, 1e-15, "world_from_stream");
  ASSERT_EQ(description.body_from_node_count, 2u);
  EXPECT_EQ(description.body_from_node[0], 2);
  EXPECT_EQ(description.body_from_node[5], 0);
  EXPECT_EQ(description.body_from_node[12], 1);
  std::vector<float> poses(24);
  ASSERT_EQ(fire3dv_get_poses(robot.get(), poses.data(), 2), FIRE3DV_OK);
  EXPECT_EQ(poses[11], 500);
  EXPECT_EQ(fire3dv_get_poses(robot.get(), poses.data(), 1), FIRE3DV_ERROR_ARGUMENT);

  RobotHandle plain(scene(R"({"node":"a"})", ""));
  ASSERT_EQ(fire3dv_get_robot_description(plain.get(), &description), FIRE3DV_OK);
  EXPECT_EQ(description.body_from_node_count, 0u);
}

}  // namespace
}  // namespace fire3dv::test
