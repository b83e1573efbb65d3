// Test of the joints that the converter writes: URDF and MJCF keep types, axes, limits and couplings, by
// their names.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <string>

#include "convert/glb/glb_joints.h"
#include "convert/glb/write_glb.h"
#include "convert/readers.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/protocol/robot/robot_handle.h"

namespace fire3dv::convert {
namespace {

using test::RobotHandle;

constexpr double kPi = std::numbers::pi;

class RobotJoints : public testing::Test {
 protected:
  Model read(const std::string& name, const std::string& text) {
    Result<Model> model = read_description(folder_.write(name, std::string_view(text)), {});
    EXPECT_TRUE(model.ok()) << model.error().message;
    return model ? std::move(*model) : Model();
  }
  Model urdf(const std::string& inside) {
    return read("arm.urdf", "<?xml version=\"1.0\"?>\n<robot name=\"arm\">" + inside + "</robot>");
  }
  Model mjcf(const std::string& inside) { return read("arm.xml", "<mujoco>" + inside + "</mujoco>"); }

  static std::vector<std::byte> glb(const Model& model) {
    std::vector<std::string> warnings;
    const auto written = write_glb(model, &warnings);
    EXPECT_TRUE(written.ok()) << written.error().message;
    return written ? *written : std::vector<std::byte>();
  }
  static bool warns(const Model& model, const std::string& part) {
    return std::any_of(model.warnings.begin(), model.warnings.end(),
                       [&](const std::string& warning) { return warning.find(part) != std::string::npos; });
  }
  test::ScratchFolder folder_;
};

std::string link(const std::string& name) {
  return "<link name=\"" + name + "\"/>\n";
}
std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& inside = "") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/>" + inside + "</joint>\n";
}

TEST_F(RobotJoints, UrdfOrderIsKept) {
  const std::string limit = "<limit lower=\"0.5\" upper=\"2\" effort=\"1\" velocity=\"1\"/>";
  const Model model = urdf(
      link("base") + link("a") + link("b") + link("c") + link("d") + link("e") + link("f") +
      joint("z", "revolute", "base", "a", "<origin xyz=\"0 0 1\"/><axis xyz=\"0 3 0\"/>" + limit) +
      joint("y", "continuous", "a", "b", "<axis xyz=\"1 0 0\"/>") +
      joint("x", "prismatic", "b", "c", "<mimic joint=\"z\" multiplier=\"-2\" offset=\"0.5\"/>" + limit) +
      joint("w", "floating", "base", "d") + joint("v", "planar", "base", "e", "<axis xyz=\"0 0 1\"/>") +
      joint("u", "fixed", "base", "f", "<origin xyz=\"0 7 0\"/>"));
  const RobotHandle robot(glb(model));
  EXPECT_EQ(robot.joint_names(), (std::vector<std::string>{"z", "y", "x", "w", "v", "u"}));
  const int32_t types[] = {FIRE3DV_JOINT_REVOLUTE, FIRE3DV_JOINT_REVOLUTE, FIRE3DV_JOINT_PRISMATIC,
                           FIRE3DV_JOINT_FLOATING, FIRE3DV_JOINT_PLANAR,   FIRE3DV_JOINT_FIXED};
  for (size_t i = 0; i < 6; ++i) EXPECT_EQ(robot.joint(i).type, types[i]) << i;
  EXPECT_STREQ(robot.joint(0).node, "a");
  EXPECT_EQ(robot.joint(0).axis[1], 1);
  EXPECT_EQ(robot.joint(0).has_limits, 1);
  EXPECT_EQ(robot.joint(0).lower, 0.5);
  EXPECT_EQ(robot.joint(0).upper, 2);
  EXPECT_EQ(robot.joint(1).has_limits, 0);
  EXPECT_EQ(robot.joint(2).followed_joint, 0);
  EXPECT_EQ(robot.joint(2).multiplier, -2);
  EXPECT_EQ(robot.joint(2).offset, 0.5);
  // 0 is outside of the limits of z: the scene shows it at 0.5.
  EXPECT_EQ(robot.positions(), (std::vector<double>{0.5, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(robot.pose("f")[7], 7);
  fire3dv_description description{};
  description.struct_size = sizeof description;
  ASSERT_EQ(fire3dv_get_robot_description(robot.get(), &description), FIRE3DV_OK);
  ASSERT_EQ(description.node_count, 7u);
  EXPECT_EQ(description.body_from_node_count, 0u);
  // Z up becomes Y up.
  EXPECT_NEAR(description.world_from_stream[6], 1, 1e-15);
  EXPECT_NEAR(description.world_from_stream[9], -1, 1e-15);
}

TEST_F(RobotJoints, InvalidMimicIsIndependent) {
  const Model model = urdf(link("base") + link("a") + link("b") + link("c") +
                           joint("j", "continuous", "base", "a", "<mimic joint=\"k\"/>") +
                           joint("k", "continuous", "a", "b", "<mimic joint=\"j\"/>") +
                           joint("l", "continuous", "b", "c", "<mimic joint=\"nobody\"/>"));
  EXPECT_TRUE(warns(model, "mimics itself, over others"));
  EXPECT_TRUE(warns(model, "joint \"l\" mimics \"nobody\""));
  const RobotHandle robot(glb(model));
  EXPECT_EQ(fire3dv_position_count(robot.get()), 2u);
}

TEST_F(RobotJoints, JointlessFilesHaveNone) {
  const Model model = urdf(link("base") + link("a") + joint("j", "fixed", "base", "a"));
  const std::vector<std::byte> file = glb(model);
  fire3dv_robot* robot = fire3dv_read_robot(file.data(), file.size(), 0);
  EXPECT_FALSE(robot);
  EXPECT_NE(std::string(fire3dv_last_error()).find("it holds no joints"), std::string::npos);
}

const char* const kMjcf = R"(<compiler angle="degree"/>
  <default><joint axis="0 1 0"/><default class="wide"><joint range="-90 90" limited="true"/></default></default>
  <worldbody><body name="base" pos="1 2 3"><freejoint/><geom size=".1"/>
    <body name="arm" pos="0 0 1"><joint name="shoulder" class="wide" pos="0 0 .5" ref="30"/>
      <joint type="slide" axis="0 0 2" range="-1 1" limited="false"/><geom size=".1"/>
      <body name="hand" pos="0 0 1"><joint name="wrist" type="ball"/><geom size=".1"/>
        <body name="finger"><joint name="finger" type="slide" range="0 .1" limited="true"/><geom size=".1"/></body>
        <body name="thumb"><joint name="thumb" type="slide"/><geom size=".1"/></body></body></body></body></worldbody>
  <equality><joint joint1="finger" joint2="shoulder" polycoef="0.01 0.5 0 0 0"/>
    <joint joint1="thumb" joint2="finger" polycoef="0 1 2 0 0"/></equality>)";

TEST_F(RobotJoints, MjcfJointsHaveAnchors) {
  const Model model = mjcf(kMjcf);
  const RobotHandle robot(glb(model));
  EXPECT_EQ(robot.joint_names(),
            (std::vector<std::string>{"joint_0", "shoulder", "joint_2", "wrist", "finger", "thumb"}));
  EXPECT_EQ(robot.joint(0).type, FIRE3DV_JOINT_FLOATING);
  EXPECT_EQ(robot.joint(1).anchor[2], 0.5);
  EXPECT_NEAR(robot.joint(1).upper, kPi / 2, 1e-15);
  EXPECT_EQ(robot.joint(2).has_limits, 0);
  EXPECT_EQ(robot.joint(2).axis[2], 1);
  EXPECT_EQ(robot.joint(3).type, FIRE3DV_JOINT_BALL);
  // finger = 0.01 + 0.5 (shoulder - 30 degrees)
  EXPECT_EQ(robot.joint(4).followed_joint, 1);
  EXPECT_EQ(robot.joint(4).multiplier, 0.5);
  EXPECT_NEAR(robot.joint(4).offset, 0.01 - 0.5 * kPi / 6, 1e-15);
  EXPECT_EQ(robot.joint(5).followed_joint, -1);
  EXPECT_TRUE(warns(model, "the coupling is not linear: \"thumb\" moves by itself"));
  const std::vector<double> initial = robot.positions();
  ASSERT_EQ(initial.size(), 7u + 1 + 1 + 4 + 1);
  EXPECT_EQ(initial[2], 3);
  EXPECT_NEAR(initial[7], kPi / 6, 1e-15);
}

TEST_F(RobotJoints, CopiedJointsStayCoupled) {
  folder_.write("gripper.xml", std::string_view(R"(<mujoco model="gripper"><worldbody><body name="grip">
      <joint name="left" type="slide"/><joint name="right" type="slide"/><geom size=".1"/></body></worldbody>
    <equality><joint joint1="right" joint2="left" polycoef="0 -1"/></equality></mujoco>)"));
  const Model model = mjcf(R"(<asset><model name="gripper" file="gripper.xml"/></asset>
    <worldbody><replicate count="2" offset="0 1 0" sep="-"><body name="arm"><joint name="j"/><geom size=".1"/>
        <body name="hand"><joint name="k"/><geom size=".1"/></body></body></replicate>
      <attach model="gripper" prefix="g_"/></worldbody>
    <equality><joint joint1="k" joint2="j"/><joint joint1="k" active="false" joint2="g_left"/></equality>)");
  const RobotHandle robot(glb(model));
  ASSERT_EQ(robot.joint_names(), (std::vector<std::string>{"j-0", "k-0", "j-1", "k-1", "g_left", "g_right"}));
  const int32_t followed[] = {-1, 0, -1, 2, -1, 4};
  for (size_t i = 0; i < 6; ++i) EXPECT_EQ(robot.joint(i).followed_joint, followed[i]) << i;
  EXPECT_EQ(robot.joint(5).multiplier, -1);
}

TEST_F(RobotJoints, AreListed) {
  const Model model = mjcf(kMjcf);
  std::vector<std::string> names;
  for (const Node& node : model.nodes) names.push_back(node.name);
  const std::vector<std::string> lines = joint_lines(model.kinematics, names);
  ASSERT_EQ(lines.size(), 6u);
  EXPECT_EQ(lines[0], "joint_0\tfloating\tbase");
  EXPECT_EQ(lines[1], "shoulder\trevolute\tarm\tfrom -1.5708 to 1.5708 rad");
  EXPECT_EQ(lines[4],
            "finger\tprismatic\tfinger\tfrom 0 to 0.1 m\tfollows shoulder times 0.5 plus -0.251799");
}

}  // namespace
}  // namespace fire3dv::convert
