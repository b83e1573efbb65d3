// Test of the rest poses of a robot whose joints are set by hand, against forward kinematics written out.
#include "renderer/state/robot_pose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <span>
#include <string_view>

#include "protocol/robot/robot_file.h"

namespace fire3dv::test {
namespace {

// A planar arm of two links of 1 m about Z, in a model frame that is Z up: world X, Y, Z = model X, Z, -Y.
// The node of the second link has scale 2. "tip" is no body.
constexpr std::string_view kFile = R"({"nodes": [
  {"name": "robot", "rotation": [-0.7071067811865476, 0, 0, 0.7071067811865476], "children": [1, 2],
   "extras": {"fire3dv": {"robot": {"version": 1,
    "bodies": [{"node": "upper"}, {"node": "lower", "parent": "upper", "translation": [1, 0, 0]},
               {"node": "lost", "parent": "upper"}],
    "joints": [
      {"name": "shoulder", "type": "revolute", "node": "upper", "axis": [0, 0, 1]},
      {"name": "elbow", "type": "revolute", "node": "lower", "axis": [0, 0, 1], "limits": [-2, 2]},
      {"name": "slide", "type": "prismatic", "node": "lower", "axis": [0, 0, 1]},
      {"name": "follower", "type": "revolute", "node": "lost", "axis": [0, 0, 1],
       "mimic": {"joint": "shoulder"}},
      {"name": "weld", "type": "fixed", "node": "lost"},
      {"name": "free", "type": "floating", "node": "lost"}]}}}},
  {"name": "upper"}, {"name": "lower", "scale": [2, 2, 2]}]})";

class RobotPoses : public ::testing::Test {
 protected:
  RobotPoses() {
    const glm::mat4 up = glm::mat4(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1);
    const uint32_t base = add("robot", up);
    add("other", at({5, 0, 0}));
    add("upper", glm::mat4(1), base);
    const uint32_t lower = add("lower", glm::scale(at({1, 0, 0}), glm::vec3(2)), base);
    add("tip", at({0.5f, 0, 0}), lower);
    pose_.set_scene(scene_, state::NodeNames(scene_));
  }
  static glm::mat4 at(glm::vec3 position) { return glm::translate(glm::mat4(1), position); }
  uint32_t add(const char* name, const glm::mat4& parent_from_node, uint32_t parent = scene::kNone) {
    scene::Node node;
    node.name = name;
    node.parent = parent;
    node.parent_from_node = parent_from_node;
    const glm::mat4 above = parent == scene::kNone ? glm::mat4(1) : scene_.nodes[parent].world_from_node;
    node.world_from_node = above * parent_from_node;
    scene_.nodes.push_back(node);
    return static_cast<uint32_t>(scene_.nodes.size() - 1);
  }
  glm::vec3 world_of(const state::RestPose& rest, std::string_view name) const {
    for (size_t node = 0; node < scene_.nodes.size(); ++node)
      if (scene_.nodes[node].name == name) return glm::vec3(rest.world_from_node[node][3]);
    ADD_FAILURE() << "no node " << name;
    return {};
  }

  scene::Scene scene_;
  state::RobotPose pose_{robot::read_robot(std::as_bytes(std::span(kFile)), true).value()};
};

void expect_near(const glm::vec3& found, const glm::vec3& wanted) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(found[i], wanted[i], 1e-6f) << "axis " << i;
}

TEST_F(RobotPoses, JointsThatMove) {
  const bool wanted[] = {true, true, true, false, false, false};
  for (size_t joint = 0; joint < std::size(wanted); ++joint) EXPECT_EQ(pose_.is_scalar(joint), wanted[joint]);
  EXPECT_EQ(scene_.nodes[pose_.node_of(1)].name, "lower");
  EXPECT_EQ(pose_.node_of(3), scene::kNone) << "the scene has no node of this body";
}

TEST_F(RobotPoses, BodiesMoveTheirChildren) {
  const double shoulder = 0.4, elbow = 0.9, slide = 0.25;
  EXPECT_FALSE(pose_.is_moved());
  EXPECT_TRUE(pose_.set({{0, {shoulder}}, {1, {elbow}}, {2, {slide}}}));
  EXPECT_FALSE(pose_.set({{0, {shoulder}}, {1, {elbow}}, {2, {slide}}})) << "nothing has changed";
  state::RestPose rest = state::rest_pose(scene_);
  const state::RestPose before = rest;
  pose_.apply(rest);
  // Of a model point (x, y, z) the world has (x, z, -y). The tip is 0.5 of the scaled link away.
  const auto x = [](double a) { return static_cast<float>(a); };
  expect_near(world_of(rest, "upper"), {0, 0, 0});
  expect_near(world_of(rest, "lower"), {x(std::cos(shoulder)), x(slide), x(-std::sin(shoulder))});
  const double both = shoulder + elbow;
  expect_near(world_of(rest, "tip"),
              {x(std::cos(shoulder) + std::cos(both)), x(slide), x(-std::sin(shoulder) - std::sin(both))});
  for (size_t node = 0; node < scene_.nodes.size(); ++node) {
    const uint32_t parent = scene_.nodes[node].parent;
    const glm::mat4 above = parent == scene::kNone ? glm::mat4(1) : rest.world_from_node[parent];
    for (int column = 0; column < 4; ++column)
      expect_near(glm::vec3((above * rest.parent_from_node[node])[column]),
                  glm::vec3(rest.world_from_node[node][column]));
  }
  EXPECT_EQ(rest.world_from_node[1], before.world_from_node[1]) << "no part of the robot has moved";
}

TEST_F(RobotPoses, PositionsAreClamped) {
  EXPECT_TRUE(pose_.set({{1, {7}}, {5, {1}}, {99, {1}}}));
  EXPECT_EQ(pose_.robot().positions()[1], 2);
  EXPECT_TRUE(pose_.set({}));
  EXPECT_FALSE(pose_.is_moved());
  state::RestPose rest = state::rest_pose(scene_);
  pose_.apply(rest);
  expect_near(world_of(rest, "tip"), {2, 0, 0});
}

}  // namespace
}  // namespace fire3dv::test
