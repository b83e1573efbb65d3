// Test of the C++ wrapper of robots, and that a published robot arrives with its frame, scales and poses.
#include "fire3dv/joints.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <utility>

#include "fire3dv/scalars.h"
#include "tests/unit/adapters/generic/client_fixture.h"

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

TEST_F(RobotHpp, PositionsAreSentAsScalars) {
  std::ofstream(file_) << R"({"asset":{"version":"2.0"},"nodes":[{"name":"robot","children":[1,2,3,4,5,6],
    "extras":{"fire3dv":{"robot":{"version":1,
      "bodies":[{"node":"a"},{"node":"b"},{"node":"c"},{"node":"d"},{"node":"e"},{"node":"f"}],
      "joints":[{"name":"hip","type":"floating","node":"a"},{"name":"knee","type":"revolute","node":"b"},
                {"name":"ball","type":"ball","node":"c"},{"name":"rail","type":"prismatic","node":"d"},
                {"name":"table","type":"planar","node":"e"},
                {"name":"toe","type":"revolute","node":"f","mimic":{"joint":"knee","multiplier":2}}]}}}},
    {"name":"a"},{"name":"b"},{"name":"c"},{"name":"d"},{"name":"e"},{"name":"f"}]})";
  auto link = std::move(*transport::open_listener(listener_uri("shm")));
  wire::Decoder decoder;
  std::map<std::string, wire::Scalars> declared;
  std::map<std::string, wire::ScalarValues> newest;
  std::set<uint64_t> declarations;  // versions: links may repeat edits
  const auto poll = [&] {
    link->wait(1ms);
    link->poll([&](const transport::LinkEvent& event) {
      if (event.kind != transport::LinkEvent::Kind::control) return;
      const auto message = decoder.decode(event.message);
      ASSERT_TRUE(message.ok()) << message.error().message;
      const auto* edit = std::get_if<wire::SceneEdit>(&*message);
      if (!edit) return;
      if (const auto* scalars = std::get_if<wire::Scalars>(&edit->value)) {
        declared[edit->node] = *scalars;
        declarations.insert(edit->version);
      }
      if (const auto* values = std::get_if<wire::ScalarValues>(&edit->value)) newest[edit->node] = *values;
    });
  };
  Stream stream(link->uri());
  Robot robot(file_.string()), other(file_.string());
  stream.describe(robot.description());
  robot.set_positions({1, 2, 3, 0, 0, 0, 1, 0.5, 0, 0, 0, 1, 0.25, 4, 5, 6});
  for (int step = 1; step <= 3; ++step) {
    robot.set_scalars(stream, std::chrono::nanoseconds(step));
    other.set_scalars(stream, std::chrono::nanoseconds(step), "other");
  }
  ASSERT_TRUE(repeat_until([&] {
    stream.publish(5ns, std::vector<Pose>(6));
    poll();
    return newest["joint_positions"].sim_time_ns == 3 && newest["other"].sim_time_ns == 3;
  }));
  const std::vector<std::string> names{"hip/x", "hip/y",   "hip/z",   "knee",
                                       "rail",  "table/x", "table/y", "table/angle"};
  EXPECT_EQ(declared["joint_positions"].names, names);
  EXPECT_EQ(declared["joint_positions"].units,
            (std::vector<std::string>{"m", "m", "m", "rad", "m", "m", "m", "rad"}));
  EXPECT_EQ(newest["joint_positions"].values, (std::vector<double>{1, 2, 3, 0.5, 0.25, 4, 5, 6}));
  EXPECT_EQ(declared["other"].names, names);
  EXPECT_EQ(declarations.size(), 2u) << "a group is declared once";
  // A group that somebody else declares meanwhile is declared anew.
  const char* const name = "x";
  const fire3dv_scalars theirs{sizeof theirs, &name, nullptr, 1};
  ASSERT_EQ(fire3dv_declare_scalars(stream.get(), "joint_positions", &theirs), FIRE3DV_OK);
  robot.set_scalars(stream, 4ns);
  ASSERT_TRUE(repeat_until([&] {
    poll();
    return newest["joint_positions"].sim_time_ns == 4;
  }));
  EXPECT_EQ(declared["joint_positions"].names, names);
  EXPECT_EQ(fire3dv_set_joint_scalars(nullptr, robot.get(), nullptr, 0), FIRE3DV_ERROR_ARGUMENT);
  EXPECT_EQ(fire3dv_set_joint_scalars(stream.get(), nullptr, nullptr, 0), FIRE3DV_ERROR_ARGUMENT);
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
