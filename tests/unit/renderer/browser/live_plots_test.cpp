// Tests of what pages of the live view get for plots and joints: bounded lists, samples in order, limits.
#include "renderer/browser/live_plots.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "protocol/robot/robot_file.h"
#include "renderer/browser/live_joints.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::app {
namespace {

using Json = nlohmann::json;
using std::chrono::milliseconds;

constexpr int64_t kBaseNs = 1'700'000'000'000'000'001;  // more digits than a double has

// A scene of two nodes, and a stream without poses.
struct World {
  scene::Scene scene;
  state::PoseState poses;
  ScalarList list;
  PlotFeed feed;
  PlotFeed::Clock::time_point now = PlotFeed::Clock::time_point() + std::chrono::hours(1);

  World() : scene(two_nodes()), poses(scene) {
    wire::StreamDescription description;
    description.adapter_name = "pendulum";
    description.epoch = 7;
    id_ = poses.add_stream(description);
  }
  static scene::Scene two_nodes() {
    scene::Scene made;
    made.nodes.resize(2);
    made.nodes[0].name = made.nodes[0].path = "base";
    made.nodes[1].name = made.nodes[1].path = "arm";
    return made;
  }
  void declare(const std::string& group, wire::Scalars scalars) {
    poses.apply(id_, {7, ++version_, group, wire::Property::scalars, std::move(scalars)});
    declarations_[group] = version_;
  }
  void sample(const std::string& group, int64_t sim_time_ns, std::vector<double> values) {
    poses.apply(id_, {7, ++version_, group, wire::Property::scalar_values,
                      wire::ScalarValues{declarations_.at(group), sim_time_ns, std::move(values)}});
  }
  // The next message after a while, acknowledged at once; null: none.
  Json take(milliseconds wait = milliseconds(100)) {
    now += wait;
    const std::optional<std::string> text = feed.take_samples(poses, now);
    if (!text) return {};
    Json message = Json::parse(*text);
    feed.on_plotted(message["number"], now);
    return message;
  }

 private:
  state::StreamId id_ = 0;
  uint64_t version_ = 0;
  std::map<std::string, uint64_t> declarations_;
};

TEST(LivePlots, ListsBoundedNumberOfScalars) {
  World world;
  world.declare("joints", {{"hin\xffge"}, {"rad"}});
  EXPECT_TRUE(world.list.update(world.poses));
  EXPECT_FALSE(world.list.update(world.poses));
  EXPECT_EQ(Json::parse(world.list.message()), Json::parse(R"({"type": "scalars", "list": 1,
      "scalars": [["pendulum", "joints", "hin?ge", "rad"]], "omitted": 0})"));
  wire::Scalars many;
  for (size_t i = 0; i < kMaxListedScalars + 3; ++i) many.names.push_back(std::to_string(i));
  many.units.resize(many.names.size());
  world.declare("many", many);
  EXPECT_EQ(ScalarList::count(world.poses), kMaxListedScalars + 4);
  EXPECT_TRUE(world.list.update(world.poses));
  const Json message = Json::parse(world.list.message());
  EXPECT_EQ(message["list"], 2);
  EXPECT_EQ(message["scalars"].size(), kMaxListedScalars);
  EXPECT_EQ(message["omitted"], 4);
}

TEST(LivePlots, ListIsSentOnceAndRateLimited) {
  World world;
  world.declare("joints", {{"hinge"}, {""}});
  (void)world.list.update(world.poses);
  EXPECT_FALSE(world.feed.take_list(world.list, world.now)) << "its plot is closed";
  world.feed.open(world.list, 0, {});
  EXPECT_TRUE(world.feed.take_list(world.list, world.now));
  EXPECT_FALSE(world.feed.take_list(world.list, world.now + milliseconds(1000)));
  world.feed.open(world.list, 0, {});  // again and again
  EXPECT_FALSE(world.feed.take_list(world.list, world.now + milliseconds(100)));
  EXPECT_TRUE(world.feed.take_list(world.list, world.now + milliseconds(300)));
  const uint32_t first = 0;
  world.feed.open(world.list, 99, {&first, 1});  // indices of another list
  world.sample("joints", 1, {1});
  EXPECT_TRUE(world.take().is_null());
}

TEST(LivePlots, SamplesKeepOrderAndDigits) {
  World world;
  world.declare("joints", {{"hinge", "speed"}, {"rad", ""}});
  for (int i = 0; i < 3; ++i) world.sample("joints", kBaseNs + i, {0.1 * i, i == 1 ? NAN : 1.0});
  (void)world.list.update(world.poses);
  const std::vector<uint32_t> both = {1, 0, 99};
  world.feed.open(world.list, 1, both);
  Json message = world.take();
  EXPECT_EQ(message["base_ns"], std::to_string(kBaseNs));
  ASSERT_EQ(message["curves"].size(), 2u);
  EXPECT_EQ(message["curves"][0],
            Json::parse(R"({"scalar": 1, "restarts": true, "t_ns": [0, 1, 2], "values": [1.0, null, 1.0]})"));
  EXPECT_EQ(message["curves"][1]["values"], Json({0.0, 0.1, 0.2}));
  EXPECT_TRUE(world.take().is_null());
  world.sample("joints", kBaseNs + 2, {0.5, 1});  // another value of the newest time
  world.sample("joints", kBaseNs + 5, {0.6, 2});
  message = world.take();
  EXPECT_EQ(message["curves"][0],
            Json::parse(R"({"scalar": 1, "restarts": false, "t_ns": [5], "values": [2.0]})"));
  EXPECT_EQ(message["curves"][1],
            Json::parse(R"({"scalar": 0, "restarts": false, "t_ns": [2, 5], "values": [0.5, 0.6]})"));
  world.sample("joints", kBaseNs - 10, {7, 7});  // time begins anew
  message = world.take();
  EXPECT_EQ(message["curves"][0],
            Json::parse(R"({"scalar": 1, "restarts": true, "t_ns": [-10], "values": [7.0]})"));
  world.declare("joints", {{"other"}, {""}});  // the list is out of date: no sample is read beyond the group
  world.sample("joints", kBaseNs, {1});
  message = world.take();
  for (const Json& curve : message.is_null() ? Json::array() : message["curves"])
    EXPECT_EQ(curve["scalar"], 0);
}

TEST(LivePlots, OneMessageIsInFlight) {
  World world;
  world.declare("joints", {{"hinge"}, {""}});
  for (int i = 0; i < 10'000; ++i) world.sample("joints", i, {1.0 * i});
  (void)world.list.update(world.poses);
  const uint32_t index = 0;
  world.feed.open(world.list, 1, {&index, 1});
  const size_t first = world.take()["curves"][0]["t_ns"].size();
  EXPECT_LE(first, PlotFeed::kMaxSamples / 4);
  EXPECT_TRUE(world.take(milliseconds(10)).is_null()) << "too early";
  size_t most = 0, sum = first;
  for (Json message = world.take(); !message.is_null(); message = world.take()) {
    const size_t samples = message["curves"][0]["t_ns"].size();
    EXPECT_EQ(message["curves"][0]["t_ns"][0], sum);
    most = std::max(most, samples);
    sum += samples;
  }
  EXPECT_EQ(sum, 10'000u);
  EXPECT_GT(most, 2 * first);
  EXPECT_LE(most, PlotFeed::kMaxSamples);
  world.sample("joints", 20'000, {1});
  world.now += milliseconds(100);
  const std::optional<std::string> unacknowledged = world.feed.take_samples(world.poses, world.now);
  ASSERT_TRUE(unacknowledged);
  world.sample("joints", 20'001, {1});
  EXPECT_TRUE(world.take().is_null());
  world.feed.on_plotted(12345, world.now);  // of no message
  EXPECT_TRUE(world.take().is_null());
  world.feed.on_plotted(Json::parse(*unacknowledged)["number"], world.now);
  EXPECT_FALSE(world.take().is_null());
}

state::RobotPose make_robot(const World& world) {
  constexpr std::string_view kFile = R"({"nodes": [{"name": "base", "children": [1],
    "extras": {"fire3dv": {"robot": {"version": 1,
      "bodies": [{"node": "base"}, {"node": "arm", "parent": "base", "translation": [0, 1, 0]}],
      "joints": [{"name": "lift", "type": "prismatic", "node": "base", "axis": [0, 1, 0]},
                 {"name": "swing", "type": "revolute", "node": "arm", "axis": [0, 0, 1], "limits": [-1, 2]}],
      "poses": [{"name": "high", "positions": [1, 0]}]}}}}, {"name": "arm"}]})";
  state::RobotPose robot(robot::read_robot(std::as_bytes(std::span(kFile)), true).value());
  robot.set_scene(world.scene, world.poses.names());
  return robot;
}

TEST(LiveJoints, JointsAreClamped) {
  World world;
  state::RobotPose robot = make_robot(world);
  EXPECT_EQ(Json::parse(joints_message(robot, 5)), Json::parse(R"({"type": "joints", "scene": 5,
      "joints": [{"name": "lift", "turns": false, "limits": null}, {"name": "swing", "turns": true, "limits": [-1.0, 2.0]}],
      "postures": ["high"]})"));
  state::JointPositions set;
  EXPECT_TRUE(move_joint(robot, world.poses, 1, 99, set));
  EXPECT_FALSE(move_joint(robot, world.poses, 2, 0, set));
  robot.set(set);
  EXPECT_EQ(Json::parse(joint_positions_message(robot, world.poses, set, 5)),
            Json::parse(R"({"type": "joint_positions",
      "scene": 5, "positions": [0.0, 2.0], "drivers": [null, null], "posture": null, "moved": true})"));
  set = robot.positions_of(0);
  robot.set(set);
  EXPECT_EQ(Json::parse(joint_positions_message(robot, world.poses, set, 5))["posture"], 0);
}

TEST(LiveJoints, DrivingStreamKeepsNode) {
  World world;
  const state::RobotPose robot = make_robot(world);
  wire::StreamDescription description;
  description.adapter_name = "driver";
  description.epoch = 8;
  description.node_names = {"arm"};
  const state::StreamId id = world.poses.add_stream(description);
  const wire::Affine3x4 pose{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
  wire::PoseFrameView frame;
  frame.header.epoch = 8;
  frame.header.sequence = 1;
  frame.node_count = 1;
  frame.poses = {&pose, 1};
  world.poses.push(id, frame);
  state::JointPositions set;
  EXPECT_TRUE(move_joint(robot, world.poses, 0, 1, set));
  EXPECT_FALSE(move_joint(robot, world.poses, 1, 1, set));
  const Json message = Json::parse(joint_positions_message(robot, world.poses, set, 5));
  EXPECT_EQ(message["drivers"], Json::parse(R"([null, "driver"])"));
}

}  // namespace
}  // namespace fire3dv::app
