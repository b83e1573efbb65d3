// Gazebo worlds: composition of relative poses, names, and changes of the scene.
#include "adapters/gazebo/world/world.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace fire3dv::gazebo {
namespace {

constexpr int64_t kMs = 1'000'000;

void set_pose(pb::Pose& pose, double x, double y, double z, double yaw = 0) {
  pose.mutable_position()->set_x(x);
  pose.mutable_position()->set_y(y);
  pose.mutable_position()->set_z(z);
  pose.mutable_orientation()->set_z(std::sin(yaw / 2));
  pose.mutable_orientation()->set_w(std::cos(yaw / 2));
}

pb::Model& add_model(pb::Scene& scene, const std::string& name, uint32_t id) {
  pb::Model& model = *scene.add_model();
  model.set_name(name);
  model.set_id(id);
  pb::Link& link = *model.add_link();
  link.set_name("link");
  link.set_id(id + 1);
  return model;
}

void add_pose(pb::PoseV& poses, uint32_t id, double x, double y, double z, double yaw = 0) {
  pb::Pose& pose = *poses.add_pose();
  pose.set_id(id);
  set_pose(pose, x, y, z, yaw);
}

pb::PoseV stamped(int64_t sec, int32_t nsec = 0) {
  pb::PoseV poses;
  poses.mutable_header()->mutable_stamp()->set_sec(sec);
  poses.mutable_header()->mutable_stamp()->set_nsec(nsec);
  return poses;
}

void stream_all(World& world) {
  for (size_t i = 0; i < world.items().size(); ++i) world.item(i).is_streamed = true;
}

std::vector<float> place_of(const World& world, const std::string& node) {
  const std::vector<std::string> names = world.node_names();
  std::vector<float> poses;
  world.write_poses(poses);
  for (size_t i = 0; i < names.size(); ++i)
    if (names[i] == node) return {poses[12 * i + 3], poses[12 * i + 7], poses[12 * i + 11]};
  return {};
}

TEST(GazeboWorld, ComposesPosesOfNestedModels) {
  pb::Scene scene;
  pb::Model& robot = add_model(scene, "robot", 10);
  pb::Model& arm = *robot.add_model();
  arm.set_name("arm");
  arm.set_id(20);
  arm.add_link()->set_name("wrist");
  arm.mutable_link(0)->set_id(21);
  World world;
  EXPECT_EQ(world.update(scene).added.size(), 1u);
  stream_all(world);
  EXPECT_EQ(world.node_names(),
            (std::vector<std::string>{"robot", "robot/link", "robot/arm", "robot/arm/wrist"}));
  pb::PoseV poses = stamped(1, 5);
  // A quarter turn to the left: +X of the arm is +Y of the world; another one: -X.
  add_pose(poses, 10, 1, 0, 0, M_PI / 2);
  add_pose(poses, 20, 2, 0, 0, M_PI / 2);
  add_pose(poses, 21, 4, 0, 1);
  const World::PoseResult result = world.apply(poses, PoseTopic::dynamic, 0);
  EXPECT_TRUE(result.is_frame);
  EXPECT_FALSE(result.is_reset);
  EXPECT_EQ(result.sim_time_ns, 1'000'000'005);
  const std::vector<float> wrist = place_of(world, "robot/arm/wrist");
  EXPECT_NEAR(wrist[0], 1 - 4, 1e-6);
  EXPECT_NEAR(wrist[1], 2, 1e-6);
  EXPECT_NEAR(wrist[2], 1, 1e-6);
}

TEST(GazeboWorld, MissingFieldsAreIdentity) {
  pb::Scene scene;
  add_model(scene, "m", 10).mutable_pose()->mutable_position()->set_x(3);
  World world;
  world.update(scene);
  stream_all(world);
  pb::PoseV poses;  // no header
  poses.add_pose()->set_id(10);
  EXPECT_TRUE(world.apply(poses, PoseTopic::full, 0).is_frame);
  EXPECT_EQ(place_of(world, "m"), (std::vector<float>{0, 0, 0}));
}

TEST(GazeboWorld, IgnoresImpossiblePoses) {
  pb::Scene scene;
  add_model(scene, "m", 10);
  World world;
  world.update(scene);
  stream_all(world);
  pb::PoseV poses = stamped(1);
  add_pose(poses, 10, std::numeric_limits<double>::quiet_NaN(), 0, 0);
  add_pose(poses, 10, 1e300, 0, 0);
  add_pose(poses, 10, 0, std::numeric_limits<double>::infinity(), 0);
  add_pose(poses, 10, 1, 2, 3);
  add_pose(poses, 10, 5, 5, 5);
  poses.mutable_pose(4)->mutable_orientation()->set_w(0);
  poses.mutable_pose(4)->mutable_orientation()->set_z(0);
  world.apply(poses, PoseTopic::dynamic, 0);
  EXPECT_EQ(world.invalid_poses(), 4u);
  EXPECT_EQ(place_of(world, "m"), (std::vector<float>{1, 2, 3}));
  poses = stamped(std::numeric_limits<int64_t>::max());
  EXPECT_FALSE(world.apply(poses, PoseTopic::dynamic, 0).is_frame);
  poses = stamped(2, -1);
  EXPECT_FALSE(world.apply(poses, PoseTopic::dynamic, 0).is_frame);
}

TEST(GazeboWorld, ReportsTimeThatGoesBack) {
  pb::Scene scene;
  add_model(scene, "m", 10);
  World world;
  world.update(scene);
  EXPECT_FALSE(world.apply(stamped(5), PoseTopic::dynamic, 0).is_reset);
  EXPECT_FALSE(world.apply(stamped(5), PoseTopic::full, 0).is_frame);  // the same time and poses
  EXPECT_FALSE(world.apply(stamped(6), PoseTopic::dynamic, 1).is_reset);
  EXPECT_FALSE(world.apply(stamped(5, 9), PoseTopic::full, 2).is_reset);  // the other topic lags behind
  const World::PoseResult reset = world.apply(stamped(1), PoseTopic::dynamic, 3);
  EXPECT_TRUE(reset.is_reset);
  EXPECT_TRUE(reset.is_frame);
  EXPECT_EQ(reset.sim_time_ns, 1'000'000'000);
  EXPECT_FALSE(world.apply(stamped(1, 1), PoseTopic::full, 4).is_reset);
}

TEST(GazeboWorld, TopicStampsStaySeparate) {
  pb::Scene scene;
  add_model(scene, "moving", 10);
  add_model(scene, "fixed", 20);
  World world;
  world.update(scene);
  stream_all(world);
  pb::PoseV dynamic = stamped(2);
  add_pose(dynamic, 10, 2, 0, 0);
  world.apply(dynamic, PoseTopic::dynamic, 0);
  pb::PoseV full = stamped(1);
  add_pose(full, 10, 1, 0, 0);
  add_pose(full, 20, 7, 0, 0);
  const World::PoseResult result = world.apply(full, PoseTopic::full, 100 * kMs);
  EXPECT_TRUE(result.is_frame);  // the fixed model was moved
  EXPECT_EQ(result.sim_time_ns, 2'000'000'000);
  EXPECT_EQ(place_of(world, "moving"), (std::vector<float>{2, 0, 0}));
  EXPECT_EQ(place_of(world, "fixed"), (std::vector<float>{7, 0, 0}));
  // The dynamic topic is silent.
  full = stamped(3);
  add_pose(full, 10, 3, 0, 0);
  EXPECT_EQ(world.apply(full, PoseTopic::full, 900 * kMs).sim_time_ns, 3'000'000'000);
  EXPECT_EQ(place_of(world, "moving"), (std::vector<float>{3, 0, 0}));
}

TEST(GazeboWorld, AsksForUnknownIdsOnce) {
  pb::Scene scene;
  add_model(scene, "m", 10);
  World world;
  world.update(scene);
  pb::PoseV poses = stamped(1);
  add_pose(poses, 99, 0, 0, 0);
  EXPECT_TRUE(world.apply(poses, PoseTopic::full, 0).has_unknown);
  world.update(scene);  // does not have it either, as for an actor
  EXPECT_FALSE(world.apply(poses, PoseTopic::full, 0).has_unknown);
}

TEST(GazeboWorld, EqualModelsStaySeparate) {
  pb::Scene scene;
  add_model(scene, "a", 10);
  add_model(scene, "b", 20);
  World world;
  world.update(scene);
  pb::Scene after;
  add_model(after, "b", 70);
  add_model(after, "c", 80);
  const World::Changes changes = world.update(after);
  ASSERT_EQ(changes.removed.size(), 1u);
  EXPECT_EQ(changes.removed[0].entities[0].name, "a");
  EXPECT_EQ(changes.added, std::vector<size_t>{1});
  // Another shape under the same name is another model.
  after.mutable_model(0)->mutable_link(0)->add_visual()->set_name("v");
  EXPECT_EQ(world.update(after).removed.size(), 1u);
  EXPECT_EQ(world.items()[0].entities[1].name, "b/link");
}

TEST(GazeboWorld, SceneNodesReturn) {
  pb::Scene scene;
  add_model(scene, "a", 10);
  World world;
  world.update(scene);
  world.item(0).is_in_file = world.item(0).is_streamed = true;
  pb::UInt32V ids;
  ids.add_data(10);
  EXPECT_EQ(world.remove(ids).first.removed.size(), 1u);
  pb::Scene after;
  add_model(after, "a", 30);
  EXPECT_EQ(world.update(after).restored, std::vector<size_t>{0});
  EXPECT_EQ(world.node_names(), (std::vector<std::string>{"a", "a/link"}));
  // One with another shape cannot take the names of the file's nodes.
  ids.set_data(0, 30);
  world.remove(ids);
  after.mutable_model(0)->mutable_link(0)->add_visual()->set_name("v");
  EXPECT_EQ(world.update(after).added.size(), 1u);
  EXPECT_EQ(world.items()[0].entities[0].name, "a model");
}

TEST(GazeboWorld, AddedNodesHavePathNames) {
  pb::Scene scene;
  pb::Model& robot = add_model(scene, "a/b", 10);
  robot.add_model()->set_name("arm");
  robot.mutable_model(0)->add_link()->set_name("wrist");
  World world;
  world.update(scene);
  stream_all(world);
  place_below(world.item(0), "added 1: a~1b");
  // SPEC.md section 7: '~' and '/' in a name are escaped, also those of the escapes in the names themselves.
  EXPECT_EQ(
      world.node_names(),
      (std::vector<std::string>{"added 1: a~01b/gazebo/a~01b", "added 1: a~01b/gazebo/a~01b/link",
                                "added 1: a~01b/gazebo/a~01b/arm", "added 1: a~01b/gazebo/a~01b/arm/wrist"}));
  // Paths that are too long for a stream are left out.
  place_below(world.item(0), std::string(1003, 'x'));
  EXPECT_EQ(world.node_names().size(), 3u);  // the wrist is
  std::vector<float> poses;
  world.write_poses(poses);
  EXPECT_EQ(poses.size(), 36u);
}

TEST(GazeboWorld, RemovesPartsByAskingAgain) {
  pb::Scene scene;
  add_model(scene, "a", 10);
  World world;
  world.update(scene);
  pb::UInt32V ids;
  ids.add_data(11);
  const auto [changes, is_whole] = world.remove(ids);
  EXPECT_TRUE(changes.empty());
  EXPECT_FALSE(is_whole);
}

TEST(GazeboWorld, TakesRepeatedIdsAndNames) {
  pb::Scene scene;
  for (int i = 0; i < 3; ++i) add_model(scene, "a", 10);
  World world;
  world.update(scene);
  stream_all(world);
  EXPECT_EQ(world.node_names(), (std::vector<std::string>{"a", "a/link", "a model", "a/link link",
                                                          "a model 2", "a/link link 2"}));
  pb::PoseV poses = stamped(1);
  add_pose(poses, 10, 1, 0, 0);
  world.apply(poses, PoseTopic::dynamic, 0);
  EXPECT_EQ(place_of(world, "a"), (std::vector<float>{1, 0, 0}));
  EXPECT_EQ(place_of(world, "a model"), (std::vector<float>{0, 0, 0}));
}

// Its digest is that of the whole model, its entities are not.
TEST(GazeboWorld, TruncatedModelDiffers) {
  const auto add = [](pb::Scene& scene, const std::string& name, uint32_t id, int visuals) {
    pb::Model& model = add_model(scene, name, id);
    for (int i = 0; i < visuals; ++i) model.mutable_link(0)->add_visual()->set_id(id + 2);
  };
  pb::Scene small, large;
  add(small, "a", 1, 100);
  add(large, "b", 10, 199'950);
  add(large, "a", 1, 100);
  World world;
  world.update(small);
  world.update(large);
  ASSERT_EQ(world.items().size(), 2u);
  EXPECT_LT(world.items()[1].entities.size(), 100u);
  world.update(small);
  ASSERT_EQ(world.items().size(), 1u);
  EXPECT_EQ(world.items()[0].entities.size(), 102u);
}

TEST(GazeboWorld, LimitsEntities) {
  pb::Scene scene;
  pb::Model& model = *scene.add_model();
  for (int i = 0; i < 250'000; ++i) model.add_link();
  World world;
  world.update(scene);
  EXPECT_EQ(world.items()[0].entities.size(), 200'000u);
  EXPECT_EQ(world.take_warnings().size(), 1u);
}

}  // namespace
}  // namespace fire3dv::gazebo
