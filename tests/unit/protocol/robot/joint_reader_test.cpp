// Test that joint positions are read from the poses that they have given, of each type of joint.
#include "protocol/robot/joint_reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace fire3dv::robot {
namespace {

constexpr double kPi = std::numbers::pi, kTolerance = 1e-12;

RobotJoint joint(const char* name, size_t body, JointType type, const Vector& axis = {0, 0, 1}) {
  RobotJoint made;
  made.name = name;
  made.body = body;
  made.type = type;
  made.axis = axis;
  made.initial.assign(position_count_of(type), 0);
  if (type == JointType::ball || type == JointType::floating) made.initial.back() = 1;
  return made;
}

// A chain: each body turned and displaced from the one before.
std::vector<RobotBody> chain(size_t count) {
  std::vector<RobotBody> bodies(count);
  for (size_t i = 0; i < count; ++i) {
    bodies[i].node = "body " + std::to_string(i);
    if (i > 0) bodies[i].parent = i - 1;
    bodies[i].parent_from_body = translation({0.1, -0.2, 0.3}) * rotation(Vector{0.6, 0, 0.8}, 0.7);
  }
  return bodies;
}

std::vector<double> read(Robot& robot) {
  const auto reader = JointReader::make(robot);
  EXPECT_TRUE(reader.ok());
  std::vector<double> positions;
  reader->read(robot.poses(), positions);
  EXPECT_EQ(positions.size(), reader->names().size());
  return positions;
}

void expect_near(const std::vector<double>& positions, const std::vector<double>& wanted) {
  ASSERT_EQ(positions.size(), wanted.size());
  for (size_t i = 0; i < wanted.size(); ++i) EXPECT_NEAR(positions[i], wanted[i], kTolerance) << i;
}

TEST(JointReader, EachTypeOfJoint) {
  std::vector<RobotJoint> joints{joint("turn", 0, JointType::revolute, {0.6, 0.8, 0}),
                                 joint("slide", 1, JointType::prismatic, {0, 0.6, 0.8}),
                                 joint("plane", 2, JointType::planar, {0.6, 0, 0.8}),
                                 joint("ball", 3, JointType::ball),
                                 joint("free", 4, JointType::floating),
                                 joint("weld", 5, JointType::fixed)};
  joints[0].anchor = {0.5, 0.1, -0.3};
  joints[0].reference = 0.25;
  joints[1].reference = -0.5;
  joints[3].anchor = {0.2, 0, 0};
  auto robot = Robot::make(chain(6), joints, {});
  ASSERT_TRUE(robot.ok());
  EXPECT_EQ(JointReader::make(*robot)->names(),
            (std::vector<std::string>{"turn", "slide", "plane.x", "plane.y", "plane.angle", "ball.qx",
                                      "ball.qy", "ball.qz", "ball.qw", "free.x", "free.y", "free.z",
                                      "free.qx", "free.qy", "free.qz", "free.qw"}));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int i = 0; i < 200; ++i) {
    std::vector<double> wanted(robot->positions().size());
    for (double& position : wanted) position = number(random);
    wanted[0] *= kPi;
    wanted[4] *= kPi;
    for (const size_t first : {size_t{5}, size_t{12}}) {
      double size = 0;
      wanted[first + 3] = std::abs(wanted[first + 3]);
      for (size_t k = first; k < first + 4; ++k) size += wanted[k] * wanted[k];
      for (size_t k = first; k < first + 4; ++k) wanted[k] /= std::sqrt(size);
    }
    ASSERT_TRUE(robot->set_positions(wanted).ok());
    expect_near(read(*robot), wanted);
  }
}

// Half turns, where the quaternion's w is 0.
TEST(JointReader, HalfTurnsOfABall) {
  auto robot = Robot::make(chain(1), {joint("ball", 0, JointType::ball)}, {});
  ASSERT_TRUE(robot.ok());
  for (size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> wanted(4);
    wanted[axis] = 1;
    ASSERT_TRUE(robot->set_positions(wanted).ok());
    const std::vector<double> found = read(*robot);
    for (size_t k = 0; k < 4; ++k) EXPECT_NEAR(std::abs(found[k]), wanted[k], kTolerance);
  }
}

TEST(JointReader, AnglesLieWithinTheLimits) {
  RobotJoint limited = joint("limited", 0, JointType::revolute);
  limited.has_limits = true;
  limited.lower = kPi / 2;
  limited.upper = 2 * kPi;
  auto robot = Robot::make(chain(2), {limited, joint("continuous", 1, JointType::revolute)}, {});
  ASSERT_TRUE(robot.ok());
  ASSERT_TRUE(robot->set_positions(std::vector<double>{1.5 * kPi, 1.5 * kPi}).ok());
  expect_near(read(*robot), {1.5 * kPi, -0.5 * kPi});
  ASSERT_TRUE(robot->set_positions(std::vector<double>{0.1, 3 * kPi}).ok());  // beyond them
  const std::vector<double> found = read(*robot);
  EXPECT_NEAR(found[0], 0.1, kTolerance);
  EXPECT_NEAR(std::abs(found[1]), kPi, kTolerance);
}

TEST(JointReader, FollowersHaveNoPosition) {
  RobotJoint follower = joint("follower", 1, JointType::revolute);
  follower.leader = 0;
  follower.multiplier = -2;
  auto robot = Robot::make(chain(2), {joint("leader", 0, JointType::revolute), follower}, {});
  ASSERT_TRUE(robot.ok());
  ASSERT_TRUE(robot->set_positions(std::vector<double>{0.4}).ok());
  expect_near(read(*robot), {0.4});
}

TEST(JointReader, SeveralJointsOfABodyAreRefused) {
  auto robot =
      Robot::make(chain(1), {joint("a", 0, JointType::revolute), joint("b", 0, JointType::prismatic)}, {});
  ASSERT_TRUE(robot.ok());
  const auto reader = JointReader::make(*robot);
  ASSERT_FALSE(reader.ok());
  EXPECT_EQ(reader.error().message, "the joints of body \"body 0\" cannot be told apart by its pose");
}

}  // namespace
}  // namespace fire3dv::robot
