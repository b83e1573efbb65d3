// Test of the animation player: selection, order, clocks, and nodes that streams drive.
#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "renderer/scene/model/math.h"
#include "renderer/state/motion/animation.h"
#include "renderer/state/motion/animation_clock.h"
#include "renderer/state/pose_state.h"
#include "tests/unit/renderer/scene/gltf/motion_file.h"

namespace fire3dv::state {
namespace {

using nlohmann::json;

// Nodes of the file: "figure" (weights); "root" (rotation by STEP: half a turn about X from 1 s to 4 s);
// "tip" below it (from (0,1,0) over (0,2,0) at 1 s to (0,6,0) at 4 s).
enum : uint32_t { kFigure, kRoot, kTip };

glm::vec3 origin(const glm::mat4& world_from_node) {
  return glm::vec3(world_from_node[3]);
}
void expect_near(const glm::vec3& value, const glm::vec3& expected) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(value[i], expected[i], 1e-4f) << i;
}

wire::StreamDescription stream_of(std::vector<std::string> names, uint64_t epoch) {
  wire::StreamDescription description;
  description.adapter_name = "simulator";
  description.epoch = epoch;
  description.node_names = std::move(names);
  return description;
}

void show(PoseState& poses, StreamId id, uint64_t sequence, int64_t sim_time_ns, const glm::mat4& pose) {
  const std::vector<wire::Affine3x4> affine{scene::to_affine(pose)};
  wire::PoseFrameView frame;
  frame.header.epoch = poses.streams()[id].epoch;
  frame.header.sequence = sequence;
  frame.header.sim_time_ns = sim_time_ns;
  frame.node_count = 1;
  frame.poses = affine;
  EXPECT_TRUE(poses.push(id, frame));
}

TEST(AnimationPlayer, DescendantsAndWeightsMove) {
  const scene::Scene scene = test::loaded_scene(test::motion_file());
  AnimationPlayer player(scene, {0});
  const RestPose& pose = player.at(0.5);
  expect_near(origin(pose.world_from_node[kTip]), {0, 1.5f, 0});
  EXPECT_EQ(origin(pose.parent_from_node[kTip]), glm::vec3(0, 1.5f, 0));
  EXPECT_EQ(pose.world_from_node[kFigure], scene.nodes[kFigure].world_from_node);
  EXPECT_EQ(pose.morph_weights, (std::vector<float>{0.5f, 0.25f}));
  player.at(2.5);  // (0, 4, 0) in "root", which is rotated by half a turn
  expect_near(origin(pose.world_from_node[kTip]), {0, -4, 0});
}

TEST(AnimationPlayer, LoopDependsOnTime) {
  const scene::Scene scene = test::loaded_scene(test::motion_file());
  EXPECT_EQ(scene.animations[0].duration_s, 4);
  AnimationPlayer player(scene, {0}), other(scene, {0});
  const RestPose first = player.at(0.75);
  player.at(3.1);
  for (const double turns : {1.0, 3.0, -2.0}) {
    const RestPose& again = player.at(0.75 + 4 * turns);
    EXPECT_EQ(again.world_from_node, first.world_from_node) << turns;
    EXPECT_EQ(again.morph_weights, first.morph_weights) << turns;
  }
  EXPECT_EQ(other.at(3.1).world_from_node, player.at(3.1).world_from_node);
}

TEST(AnimationPlayer, UnanimatedNodesRest) {
  test::GltfBuilder builder = test::motion_file();
  builder.root["animations"][0]["channels"].erase(1);  // the rotation of "root"
  builder.root["nodes"][2]["rotation"] = {0, 0, 1, 0};
  builder.root["nodes"][2]["scale"] = {2, 3, 4};
  const scene::Scene scene = test::loaded_scene(builder);
  AnimationPlayer player(scene, {0});
  glm::mat4 expected = scene.nodes[kTip].parent_from_node;
  expected[3] = glm::vec4(0, 1.5f, 0, 1);
  EXPECT_EQ(player.at(0.5).parent_from_node[kTip], expected);
}

TEST(AnimationPlayer, LastAnimationWins) {
  test::GltfBuilder builder = test::motion_file();
  json& animations = builder.root["animations"];
  animations.push_back(animations[0]);
  animations[1]["channels"] = {animations[0]["channels"][0]};
  animations[1]["samplers"][0]["output"] =
      builder.add_data<float>({9, 0, 0, 9, 0, 0, 9, 0, 0}, "VEC3", test::kFloat, 3);
  const scene::Scene scene = test::loaded_scene(builder);
  AnimationPlayer player(scene, {0, 1});
  EXPECT_EQ(origin(player.at(0.5).parent_from_node[kTip]), glm::vec3(9, 0, 0));
}

TEST(AnimationChoice, SelectionByNameIndexOrAll) {
  test::GltfBuilder builder = test::motion_file();
  json& animations = builder.root["animations"];
  const json channels = animations[0]["channels"];
  animations.push_back(animations[0]);  // 1: the same again
  animations[1]["name"] = "again";
  animations.push_back(animations[0]);  // 2: another path of the same node
  animations[2]["name"] = "twice";
  animations[2]["channels"] = json::array({channels[0]});
  animations[2]["channels"][0]["target"]["path"] = "scale";
  animations.push_back(animations[2]);  // 3: no channels
  animations[3]["channels"] = json::array();
  const scene::Scene scene = test::loaded_scene(builder);
  const auto chosen = [&](const char* argument) {
    auto result = choose_animations(scene, argument);
    return result ? *result : std::vector<uint32_t>{};
  };
  EXPECT_EQ(chosen("wave"), std::vector<uint32_t>{0});
  EXPECT_EQ(chosen("again"), std::vector<uint32_t>{1});
  EXPECT_EQ(chosen("3"), std::vector<uint32_t>{3});
  EXPECT_EQ(chosen("all"), (std::vector<uint32_t>{0, 2}));
  for (const char* wrong : {"", "4", "-1", "1x", "Wave", "99999999999999999999"}) {
    const auto result = choose_animations(scene, wrong);
    ASSERT_FALSE(result.ok()) << wrong;
    EXPECT_NE(result.error().message.find("there are 0 \"wave\", 1 \"again\""), std::string::npos)
        << result.error().message;
  }
  const auto twice = choose_animations(scene, "twice");
  ASSERT_FALSE(twice.ok());
  EXPECT_NE(twice.error().message.find("2 animations have that name"), std::string::npos);
  EXPECT_FALSE(choose_animations(scene::Scene{}, "all").ok());
}

TEST(AnimatedPoses, UndrivenNodesFollowAnimation) {
  const scene::Scene scene = test::loaded_scene(test::motion_file());
  PoseState poses(scene);
  AnimationPlayer player(scene, {0});
  const uint64_t before = poses.drive_revision();
  poses.set_rest(player.at(0.5));
  EXPECT_GT(poses.drive_revision(), before);
  EXPECT_EQ(poses.morph_weights(), (std::vector<float>{0.5f, 0.25f}));
  expect_near(origin(poses.world_from_node(kTip)), {0, 1.5f, 0});
  EXPECT_EQ(poses.node_drives()[kTip].body_from_node, scene::to_affine(poses.world_from_node(kTip)))
      << "what is uploaded";

  // The stream drives "root": the stream replaces its rotation, and "tip" stays animated below it.
  const StreamId root = poses.add_stream(stream_of({"root"}, 1));
  show(poses, root, 1, 0, glm::translate(glm::mat4(1), glm::vec3(10, 0, 0)));
  poses.set_rest(player.at(2.5));
  expect_near(origin(poses.world_from_node(kRoot)), {10, 0, 0});
  expect_near(origin(poses.world_from_node(kTip)), {10, 4, 0});

  // The stream drives "tip" alone: its pose is the stream's.
  poses.remove_stream(root);
  const StreamId tip = poses.add_stream(stream_of({"tip"}, 2));
  show(poses, tip, 1, 0, glm::translate(glm::mat4(1), glm::vec3(0, 0, 7)));
  for (const double time : {0.5, 2.5}) {
    poses.set_rest(player.at(time));
    expect_near(origin(poses.world_from_node(kTip)), {0, 0, 7});
  }
  poses.remove_stream(tip);
  expect_near(origin(poses.world_from_node(kTip)), {0, -4, 0});
}

TEST(AnimatedPoses, SimulatedTimeIsNewestStreams) {
  const scene::Scene scene = test::loaded_scene(test::motion_file());
  PoseState poses(scene);
  EXPECT_FALSE(poses.sim_time_ns());
  const StreamId first = poses.add_stream(stream_of({"root"}, 1));
  const StreamId second = poses.add_stream(stream_of({"tip"}, 2));
  EXPECT_FALSE(poses.sim_time_ns()) << "nothing is shown yet";
  show(poses, first, 1, 100, glm::mat4(1));
  EXPECT_EQ(poses.sim_time_ns(), 100);
  show(poses, second, 1, 5, glm::mat4(1));
  EXPECT_EQ(poses.sim_time_ns(), 5);
  show(poses, first, 2, 200, glm::mat4(1));
  EXPECT_EQ(poses.sim_time_ns(), 5) << "time does not jump between two streams";
  poses.remove_stream(second);
  EXPECT_EQ(poses.sim_time_ns(), 200);
}

TEST(AnimationClock, ClockContinuesAfterStream) {
  state::AnimationClock clock;
  EXPECT_DOUBLE_EQ(clock.at({}, 0), 0);
  EXPECT_DOUBLE_EQ(clock.at({}, 1.5), 1.5);
  EXPECT_DOUBLE_EQ(clock.at(40'000'000'000, 2), 40);
  EXPECT_DOUBLE_EQ(clock.at(40'000'000'000, 3), 40) << "a paused simulator pauses the animation";
  EXPECT_DOUBLE_EQ(clock.at({}, 3.25), 40.25);
}

}  // namespace
}  // namespace fire3dv::state
