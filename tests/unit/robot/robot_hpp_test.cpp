// Test of the C++ wrapper of robots, and that a published robot arrives with its frame, scales and poses.
#include "fire3dv/joints.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <utility>

#include "tests/unit/adapters/client_fixture.h"

namespace fire3dv::test {
namespace {

using namespace std::chrono_literals;

class RobotHpp : public testing::Test {
 protected:
  RobotHpp() {
    std::ofstream(file_) << R"({"asset":{"version":"2.0"},"nodes":[{"name":"robot","children":[1,2],
      "rotation":[-0.7071067811865476,0,0,0.7071067811865476],"extras":{"fire3dv":{"robot":{"version":1,
        "bodies":[{"node":"upper","translation":[0,0,1]},{"node":"fore","parent":"upper","translation":[2,0,0]}],
        "joints":[{"name":"shoulder","type":"revolute","node":"upper","limits":[-1,1]},
                  {"name":"elbow","type":"revolute","node":"fore"}]}}}},
      {"name":"upper"},{"name":"fore","scale":[0.001,0.001,0.001]}]})";
  }
  ~RobotHpp() override { std::filesystem::remove(file_); }

  const std::filesystem::path file_ =
      std::filesystem::temp_directory_path() / ("robot-hpp-" + std::to_string(::getpid()) + ".gltf");
};

TEST_F(RobotHpp, PublishesWhatItComputes) {
  Renderer renderer(listener_uri("shm"));
  ASSERT_NE(renderer.link, nullptr);
  Stream stream(renderer.link->uri(), "wrapper");
  Robot opened(file_.string());
  Robot robot = std::move(opened);
  ASSERT_EQ(robot.joints().size(), 2u);
  EXPECT_STREQ(robot.joints()[0].name, "shoulder");
  EXPECT_EQ(robot.joints()[0].upper, 1);
  stream.describe(robot.description());
  robot.set_positions({2, 0.25}, FIRE3DV_POSITIONS_CLAMP);
  EXPECT_EQ(robot.positions(), (std::vector<double>{1, 0.25}));
  robot.set_joint(0, {0.5});
  robot.set_base({1, 0, 0, 10, 0, 1, 0, 0, 0, 0, 1, 0});
  EXPECT_NEAR(robot.node_pose("fore")[3], 10 + 2 * std::cos(0.5), 1e-14);
  ASSERT_TRUE(repeat_until([&] {
    robot.publish(stream, 5ns);
    renderer.poll();
    return !renderer.descriptions.empty() && renderer.has_whole_frame();
  }));
  const wire::StreamDescription& description = renderer.descriptions.front();
  EXPECT_EQ(description.node_names, (std::vector<std::string>{"upper", "fore"}));
  EXPECT_NEAR(description.world_from_stream.m[6], 1, 1e-15);
  ASSERT_EQ(description.body_from_node.size(), 2u);
  EXPECT_FLOAT_EQ(description.body_from_node[0].m[0], 1);
  EXPECT_FLOAT_EQ(description.body_from_node[1].m[0], 0.001f);
  ASSERT_EQ(renderer.poses.size(), 2u);
  EXPECT_FLOAT_EQ(renderer.poses[1].m[3], static_cast<float>(10 + 2 * std::cos(0.5)));
  EXPECT_FLOAT_EQ(renderer.poses[1].m[0], static_cast<float>(std::cos(0.75)));
}

TEST_F(RobotHpp, ThrowsWithTheSentence) {
  const auto sentence = [](const std::function<void()>& call) {
    try {
      call();
    } catch (const ClientError& error) {
      return std::string(error.what());
    }
    return std::string("nothing was thrown");
  };
  EXPECT_NE(sentence([] { Robot robot("/none.glb"); }).find("/none.glb"), std::string::npos);
  Robot robot(file_.string());
  EXPECT_EQ(sentence([&] { robot.set_positions({1}); }), "there are 1 positions; the robot has 2");
  EXPECT_EQ(sentence([&] { robot.node_pose("x"); }), "the robot has no body \"x\"");
  Stream stream(unique_shm_uri());
  EXPECT_NE(sentence([&] { robot.publish(stream, 0ns); }).find("no description yet"), std::string::npos);
}

}  // namespace
}  // namespace fire3dv::test
