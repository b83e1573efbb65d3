// Test of forward kinematics of MJCF models against mj_kinematics: random coordinates, with anchors,
// references and several joints of a body; and of public robots.
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <span>

#include "adapters/mujoco/compiled/load.h"
#include "convert/glb/write_glb.h"
#include "convert/readers.h"
#include "protocol/robot/robot_file.h"
#include "tests/support/asset_collection_folder.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/protocol/robot/robot_handle.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;
using test::expect_near;
using test::Pose12;
using test::RobotHandle;

constexpr double kTolerance = 1e-9;

Pose12 pose_in(const mjData& data, int body) {
  const double *p = data.xpos + 3 * body, *m = data.xmat + 9 * body;
  return {m[0], m[1], m[2], p[0], m[3], m[4], m[5], p[1], m[6], m[7], m[8], p[2]};
}

void compare(const fs::path& file) {
  std::vector<std::string> warnings;
  const Result<MjcfModel> compiled = compile_mjcf(file, &warnings);
  ASSERT_TRUE(compiled.ok()) << file << ": " << compiled.error().message;
  const mjModel& model = **compiled;
  const Result<MjcfData> posed = pose_mjcf(model, &warnings);
  ASSERT_TRUE(posed.ok());
  mjData& data = **posed;
  const Result<Model> read = read_description(file, {});
  ASSERT_TRUE(read.ok()) << read.error().message;
  const auto glb = write_glb(*read);
  ASSERT_TRUE(glb.ok()) << glb.error().message;
  const RobotHandle robot(*glb, FIRE3DV_ROBOT_NO_MIMIC);
  ASSERT_EQ(fire3dv_position_count(robot.get()), static_cast<size_t>(model.nq)) << file;

  // The scene's pose is the first keyframe's.
  size_t compared = 0;
  const auto compare_bodies = [&](const std::string& what) {
    double extent = 1;
    for (int i = 0; i < 3 * model.nbody; ++i) extent = std::max(extent, std::abs(data.xpos[i]));
    for (int body = 1; body < model.nbody; ++body) {
      const char* name = mj_id2name(&model, mjOBJ_BODY, body);
      const std::string node = name && *name ? name : "body_" + std::to_string(body);
      expect_near(robot.pose(node), pose_in(data, body), kTolerance * extent, what + ", " + node);
      ++compared;
    }
  };
  compare_bodies("scene");
  std::mt19937 random(7);
  std::normal_distribution<double> number(0, 2);
  for (int run = 0; run < 20; ++run) {
    std::vector<double> qpos(static_cast<size_t>(model.nq));
    for (double& q : qpos) q = number(random);
    std::copy(qpos.begin(), qpos.end(), data.qpos);
    mj_kinematics(&model, &data);
    EXPECT_EQ(fire3dv_set_positions(robot.get(), qpos.data(), qpos.size(), FIRE3DV_POSITIONS_WXYZ),
              FIRE3DV_OK)
        << fire3dv_last_error();
    compare_bodies("run " + std::to_string(run));
  }
  EXPECT_EQ(compared, 21 * static_cast<size_t>(model.nbody - 1));

  // Named poses are the keyframes.
  robot::Robot own = robot::read_robot(std::as_bytes(std::span(*glb)), false).value();
  ASSERT_EQ(own.named_poses().size(), static_cast<size_t>(model.nkey));
  for (int key = 0; key < model.nkey; ++key) {
    const robot::NamedPose& pose = own.named_poses()[static_cast<size_t>(key)];
    const char* name = mj_id2name(&model, mjOBJ_KEY, key);
    EXPECT_EQ(pose.name, name && *name ? name : "key " + std::to_string(key));
    std::copy_n(model.key_qpos + key * model.nq, model.nq, data.qpos);
    mj_kinematics(&model, &data);
    ASSERT_TRUE(own.set_positions(pose.positions).ok());
    for (int body = 1; body < model.nbody; ++body) {
      const char* node = mj_id2name(&model, mjOBJ_BODY, body);
      const size_t index = own.body_called(node && *node ? node : "body_" + std::to_string(body)).value();
      expect_near(own.poses()[index].m, pose_in(data, body), kTolerance * 10, pose.name);
    }
  }
}

void compare_text(const std::string& text) {
  const test::ScratchFolder folder;
  compare(folder.write("robot.xml", std::string_view("<mujoco>" + text + "</mujoco>")));
}

TEST(RobotMujoco, AllJointTypesMatch) {
  compare_text(R"(<compiler eulerseq="zyx"/><default><joint axis="0 1 0"/></default><worldbody>
    <body name="free" pos="1 2 3" euler="10 20 30"><freejoint name="root"/><geom size=".1"/>
      <body name="ball" pos="0 1 0" euler="0 30 0"><joint type="ball" pos=".1 .2 .3"/><geom size=".1"/>
        <body name="two" pos="0 0 1" quat="1 2 3 4"><joint type="slide" axis="1 1 0" ref=".5"/>
          <joint axis="0 2 0" pos="0 0 .2" ref="20"/><joint axis="1 0 3" pos="0 .1 0"/><geom type="box" size=".1 .2 .3"/>
          <body pos=".3 0 0"><geom size=".1"/><body><joint pos="1 2 3"/><joint type="ball" pos="-1 0 2"/>
            <geom size=".1"/></body></body></body></body></body>
    <body name="arm" pos="2 2 2" axisangle="1 1 1 50"><joint name="j" axis="0 0 1" range="-30 60" limited="true"/>
      <geom size=".2" pos="1 0 0"/><body name="hand" pos="1 0 0"><joint name="k" type="slide"/><geom size=".1"/></body></body>
    </worldbody>
    <equality><joint joint1="k" joint2="j" polycoef="0.1 2 0 0 0"/></equality>
    <keyframe><key qpos="3 2 1 1 1 0 0 1 0 2 0 .7 .4 -.6 .3 1 2 3 4 .5 .6"/>
      <key name="home" qpos="0 1 0 1 0 0 0 1 0 0 0 0 0 0 0 1 0 1 0 .2 .3"/></keyframe>)");
}

TEST(RobotMujoco, FramesOfMotionCapture) {
  compare_text(R"(<worldbody><body name="moved" mocap="true" pos="0 0 4" euler="0 0 30"><geom size=".2"/>
      <body name="on it" pos="1 0 0"><geom size=".1"/></body></body>
    <body name="b" pos="0 0 1"><joint/><geom size=".1"/></body></worldbody>
    <keyframe><key qpos=".5" mpos="7 8 9" mquat="1 0 0 1"/></keyframe>)");
}

TEST(RobotMujoco, CollectionRobotsAgree) {
  FIRE3DV_NEEDS_ASSETS();
  for (const char* model :
       {"franka_emika_panda/scene.xml", "franka_emika_panda/hand.xml", "robotiq_2f85/2f85.xml"}) {
    const fs::path file = test::asset_collection_folder() / "robots" / model;
    ASSERT_TRUE(fs::exists(file)) << file;
    compare(file);
  }
}

}  // namespace
}  // namespace fire3dv::convert
