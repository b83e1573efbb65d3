// Test of forward kinematics of URDF robots against KDL, whose trees are built as kdl_parser does: five
// robots, random positions.
#include <gtest/gtest.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <cmath>
#include <kdl/tree.hpp>
#include <kdl/treefksolverpos_recursive.hpp>
#include <map>
#include <random>
#include <sstream>

#include "convert/glb/write_glb.h"
#include "convert/readers.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/protocol/robot/robot_handle.h"

namespace fire3dv::convert {
namespace {

using test::expect_near;
using test::Pose12;
using test::RobotHandle;

KDL::Vector vector(const urdf::Vector3& v) {
  return {v.x, v.y, v.z};
}

KDL::Frame frame(const urdf::Pose& pose) {
  const urdf::Rotation& r = pose.rotation;
  return {KDL::Rotation::Quaternion(r.x, r.y, r.z, r.w), vector(pose.position)};
}

KDL::Joint kdl_joint(const urdf::Joint& joint) {
  const KDL::Frame origin = frame(joint.parent_to_joint_origin_transform);
  const KDL::Vector axis = origin.M * vector(joint.axis);
  switch (joint.type) {
    case urdf::Joint::REVOLUTE:
    case urdf::Joint::CONTINUOUS:
      return {joint.name, origin.p, axis, KDL::Joint::RotAxis};
    case urdf::Joint::PRISMATIC:
      return {joint.name, origin.p, axis, KDL::Joint::TransAxis};
    default:
      return KDL::Joint(joint.name, KDL::Joint::Fixed);
  }
}

void add_children(const urdf::Link& link, KDL::Tree& tree) {
  for (const urdf::LinkSharedPtr& child : link.child_links) {
    const urdf::Joint& joint = *child->parent_joint;
    ASSERT_TRUE(tree.addSegment(
        KDL::Segment(child->name, kdl_joint(joint), frame(joint.parent_to_joint_origin_transform)),
        link.name));
    add_children(*child, tree);
  }
}

void compare(const std::string& inside, size_t joints) {
  const test::ScratchFolder folder;
  const std::string text = "<?xml version=\"1.0\"?>\n<robot name=\"robot\">" + inside + "</robot>";
  const Result<Model> model = read_urdf(folder.write("robot.urdf", std::string_view(text)), {});
  ASSERT_TRUE(model.ok()) << model.error().message;
  const auto glb = write_glb(*model);
  ASSERT_TRUE(glb.ok()) << glb.error().message;
  const RobotHandle robot(*glb);
  ASSERT_EQ(fire3dv_position_count(robot.get()), joints);

  const urdf::ModelInterfaceSharedPtr urdf = urdf::parseURDF(text);
  ASSERT_TRUE(urdf);
  KDL::Tree tree(urdf->getRoot()->name);
  add_children(*urdf->getRoot(), tree);
  KDL::TreeFkSolverPos_recursive solver(tree);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-4, 4);
  size_t compared = 0;
  for (int run = 0; run < 20; ++run) {
    std::map<std::string, double> values;
    for (size_t i = 0; i < fire3dv_joint_count(robot.get()); ++i) {
      const fire3dv_joint joint = robot.joint(i);
      if (joint.position_count == 0) continue;
      const double value = values[joint.name] = number(random);
      ASSERT_EQ(fire3dv_set_joint(robot.get(), i, &value, 1, 0), FIRE3DV_OK) << fire3dv_last_error();
    }
    // What URDF says of joints that mimic others.
    for (size_t pass = 0; pass < 3; ++pass)
      for (const auto& [name, joint] : urdf->joints_)
        if (joint->mimic)
          values[name] = joint->mimic->multiplier * values[joint->mimic->joint_name] + joint->mimic->offset;
    KDL::JntArray positions(tree.getNrOfJoints());
    for (const auto& [name, segment] : tree.getSegments())
      if (segment.segment.getJoint().getType() != KDL::Joint::Fixed)
        positions(segment.q_nr) = values.at(segment.segment.getJoint().getName());
    for (const auto& [name, link] : urdf->links_) {
      if (name == urdf->getRoot()->name) continue;
      KDL::Frame expected;
      ASSERT_EQ(solver.JntToCart(positions, expected, name), 0);
      const double extent =
          std::max({1.0, std::abs(expected.p.x()), std::abs(expected.p.y()), std::abs(expected.p.z())});
      Pose12 pose{};
      for (unsigned row = 0; row < 3; ++row) {
        for (unsigned column = 0; column < 3; ++column)
          pose[row * 4 + column] = expected.M(static_cast<int>(row), static_cast<int>(column));
        pose[row * 4 + 3] = expected.p(static_cast<int>(row));
      }
      expect_near(robot.pose(name), pose, 1e-9 * extent, name + ", run " + std::to_string(run));
      ++compared;
    }
  }
  EXPECT_EQ(compared, 20 * (urdf->links_.size() - 1));
}

std::string link(const std::string& name) {
  return "<link name=\"" + name + "\"/>";
}
std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& inside) {
  const std::string limit = type == "revolute" || type == "prismatic"
                                ? "<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>"
                                : "";
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/>" + limit + inside + "</joint>";
}

TEST(RobotKdl, PlanarArm) {
  compare(
      link("base") + link("upper") + link("fore") + link("tool") +
          joint("shoulder", "revolute", "base", "upper", "<origin xyz=\"0 0 .5\"/><axis xyz=\"0 0 1\"/>") +
          joint("elbow", "continuous", "upper", "fore", "<origin xyz=\".4 0 0\"/><axis xyz=\"0 0 1\"/>") +
          joint("mount", "fixed", "fore", "tool", "<origin xyz=\".3 0 0\" rpy=\".1 .2 .3\"/>"),
      2);
}

// Numbers of a UR5e, from its data sheet: offsets along and turns about the axes of six joints.
TEST(RobotKdl, SixAxisArm) {
  const char* const origins[] = {"xyz=\"0 0 0.1625\"",
                                 "rpy=\"1.570796327 0 0\"",
                                 "xyz=\"-0.425 0 0\"",
                                 "xyz=\"-0.3922 0 0.1333\"",
                                 "xyz=\"0 -0.0997 0\" rpy=\"1.570796327 0 0\"",
                                 "xyz=\"0 0.0996 0\" rpy=\"1.570796326 3.141592653 3.141592653\""};
  std::string robot = link("l0");
  for (int i = 0; i < 6; ++i)
    robot += link("l" + std::to_string(i + 1)) +
             joint("j" + std::to_string(i), "revolute", "l" + std::to_string(i), "l" + std::to_string(i + 1),
                   std::string("<origin ") + origins[i] + "/><axis xyz=\"0 0 1\"/>");
  compare(robot, 6);
}

TEST(RobotKdl, Scara) {
  compare(link("base") + link("a") + link("b") + link("c") + link("d") +
              joint("j1", "continuous", "base", "a", "<origin xyz=\"0 0 .2\"/><axis xyz=\"0 0 1\"/>") +
              joint("j2", "revolute", "a", "b", "<origin xyz=\".225 0 0\"/><axis xyz=\"0 0 1\"/>") +
              joint("j3", "prismatic", "b", "c",
                    "<origin xyz=\".175 0 .05\" rpy=\"3.14159265 0 0\"/><axis xyz=\"0 0 1\"/>") +
              joint("j4", "continuous", "c", "d", "<axis xyz=\"0 0 -1\"/>"),
          4);
}

TEST(RobotKdl, GripperWithMimic) {
  compare(
      link("palm") + link("left") + link("right") + link("left tip") + link("right tip") +
          joint("finger", "prismatic", "palm", "left",
                "<origin xyz=\"0 .02 .1\" rpy=\"0 0 .7\"/><axis xyz=\"0 1 .5\"/>") +
          joint("tip", "revolute", "left", "left tip",
                "<origin rpy=\".3 .2 .1\"/><axis xyz=\"1 2 3\"/><mimic joint=\"other\" multiplier=\"2\"/>") +
          joint("other", "prismatic", "palm", "right",
                "<axis xyz=\"0 -1 0\"/><mimic joint=\"finger\" multiplier=\"-1.5\" offset=\".25\"/>") +
          joint("other tip", "continuous", "right", "right tip",
                "<axis xyz=\"1 0 0\"/><mimic joint=\"finger\"/>"),
      1);
}

// Tree of 60 links: any joint may have any origin and axis.
TEST(RobotKdl, RandomTree) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(-2, 2);
  const auto three = [&] {
    std::ostringstream text;
    text.precision(17);
    text << number(random) << " " << number(random) << " " << number(random);
    return text.str();
  };
  std::string robot = link("l0");
  size_t moving = 0;
  for (unsigned i = 1; i < 60; ++i) {
    const char* const types[] = {"revolute", "prismatic", "continuous", "fixed"};
    const char* const type = types[random() % 4];
    moving += std::string(type) != "fixed";
    robot +=
        link("l" + std::to_string(i)) +
        joint("j" + std::to_string(i), type, "l" + std::to_string(random() % i), "l" + std::to_string(i),
              "<origin xyz=\"" + three() + "\" rpy=\"" + three() + "\"/><axis xyz=\"" + three() + "\"/>");
  }
  compare(robot, moving);
}

}  // namespace
}  // namespace fire3dv::convert
