// Test of the MJCF reader against libmujoco: world poses, sizes, colours and drawn vertices are those of the
// compiled model at rest. Models are written by the test; public robots are compared where shared/assets is
// present.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <string_view>

#include "adapters/mujoco/compiled/load.h"
#include "convert/mjcf/mjcf_reader.h"
#include "tests/support/asset_collection_folder.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/convert/mesh/mesh_file_bytes.h"
#include "tests/unit/convert/mjcf/mjcf_oracle.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;

class MjcfOracleTest : public testing::Test {
 protected:
  void compare(const fs::path& file, const std::string& label) {
    std::vector<std::string> warnings;
    const Result<MjcfModel> compiled = compile_mjcf(file, &warnings);
    ASSERT_TRUE(compiled.ok()) << label << ": " << compiled.error().message;
    const Result<MjcfData> posed = pose_mjcf(**compiled, &warnings);
    ASSERT_TRUE(posed.ok()) << label;
    Sources sources;
    const Result<MjcfScene> read = read_mjcf_scene(file, {}, sources, warnings);
    ASSERT_TRUE(read.ok()) << label << ": " << read.error().message;
    for (const std::string& difference : MjcfOracle(*read, compiled_scene(**compiled, **posed)).differences())
      ADD_FAILURE() << label << ": " << difference;
  }
  void compare_text(const std::string& label, const std::string& text) {
    compare(folder_.write(label + ".xml", std::string_view("<mujoco>" + text + "</mujoco>")), label);
  }
  test::ScratchFolder folder_;
};

TEST_F(MjcfOracleTest, Orientations) {
  const std::string bodies = R"(<worldbody>
    <body name="a" pos="1 2 3" axisangle="1 2 0 40"><geom type="box" size=".1 .2 .3" euler="10 20 30"/>
      <body name="b" pos=".5 0 0" xyaxes="1 1 0 0 1 1"><geom type="capsule" fromto="0 0 0 .1 .2 .3" size=".05"/>
        <body name="c" zaxis="1 2 3"><geom type="cylinder" size=".1 .2" zaxis="0 0 -1"/>
          <body name="d" euler="30 -40 50"><geom type="ellipsoid" size=".1 .2 .3" quat="1 2 3 4"/>
            <camera name="eye" pos="0 0 1" euler="90 0 10" fovy="60"/><site name="s" pos="3 0 0"/>
          </body></body></body></body>
    <geom type="box" fromto="0 0 0 0 0 -2" size=".3"/><geom type="ellipsoid" fromto="1 0 0 0 1 0" size=".2"/>
  </worldbody>)";
  compare_text("degrees", bodies);
  for (const char* sequence : {"zyx", "XYZ", "xZy"})
    compare_text(std::string("sequence_") + sequence,
                 "<compiler eulerseq='" + std::string(sequence) + "'/>" + bodies);
  compare_text("radians",
               "<compiler angle='radian'/><worldbody><body euler='.1 .2 .3'><joint ref='.3' axis='1 2 3'/>"
               "<geom size='1'/></body></worldbody><keyframe><key qpos='1.1'/></keyframe>");
}

TEST_F(MjcfOracleTest, JointsInFirstKeyframe) {
  compare_text("joints", R"(<worldbody>
    <body name="free" pos="1 0 0"><freejoint/><geom size=".1"/>
      <body name="ball" pos="0 1 0" euler="0 30 0"><joint type="ball" pos=".1 .2 .3"/><geom size=".1"/>
        <body name="two" pos="0 0 1"><joint type="slide" axis="1 1 0" ref=".5"/><joint axis="0 2 0" pos="0 0 .2" ref="20"/>
          <joint axis="1 0 0" pos="0 .1 0"/><geom type="box" size=".1 .2 .3"/></body></body></body>
    <body name="moved" mocap="true" pos="0 0 4"><geom size=".2"/></body>
    <body name="static" pos="2 2 2"><geom size=".2" pos="1 0 0"/></body></worldbody>
    <keyframe><key qpos="3 2 1 1 1 0 0 1 0 2 0 .7 .4 -.6" mpos="7 8 9" mquat="1 0 0 1"/><key qpos="0 0 0 1 0 0 0 1 0 0 0 0 0 0"/></keyframe>)");
}

TEST_F(MjcfOracleTest, DefaultClasses) {
  compare_text("classes",
               R"(<default><geom type="capsule" size=".1 .3" rgba="1 0 0 1" group="1"/><joint axis="1 0 0"/>
      <default class="wide"><geom size=".2"/><default class="box"><geom type="box" size=".4 .5 .6" euler="0 0 45"/></default></default>
      <default class="eye"><camera fovy="30" pos="1 2 3"/><light dir="1 1 -1" diffuse=".1 .2 .3" directional="true"/></default></default>
    <worldbody><body childclass="wide"><joint/><geom/><geom class="box"/><geom class="main"/><geom size=".7"/>
      <body><geom class="box" size=".9"/><camera class="eye"/><light class="eye"/>
        <body childclass="box"><geom/><geom type="sphere"/></body></body></body></worldbody>
    <keyframe><key qpos=".3"/></keyframe>)");
}

TEST_F(MjcfOracleTest, TrackingMatchesMuJoCo) {
  compare_text("tracking",
               R"(<worldbody><light name="sun" directional="true" dir="0 1 -1" mode="targetbody" target="b"/>
    <camera name="at_b" pos="5 5 5" mode="targetbody" target="b"/><camera name="at_mass" pos="5 -5 5" mode="targetbodycom" target="a"/>
    <body name="a" pos="0 0 1"><freejoint/><geom type="box" size=".3 .1 .1" mass="2"/>
      <camera name="track" pos="1 0 0" euler="20 30 0" mode="track"/><camera name="com" pos="1 0 1" mode="trackcom"/>
      <light name="lamp" pos="0 0 1" dir="1 0 -1" mode="trackcom" cutoff="30"/><light name="point" pos="0 1 1" mode="track" cutoff="120"/>
      <body name="b" pos="1 0 0"><joint axis="0 1 0"/><geom type="capsule" size=".1 .2" pos="0 0 .5" density="500"/>
        <inertial pos=".2 .1 0" mass="3" diaginertia="1 1 1"/></body></body></worldbody>
    <keyframe><key qpos="3 2 1 .5 .5 .5 .5 .8"/></keyframe>)");
}

TEST_F(MjcfOracleTest, MeshesAndTheirPrimitives) {
  folder_.write("wedge.obj",
                std::string_view("v 0 0 0\nv 2 0 0\nv 0 1 0\nv 0 0 .5\nv 2 0 .5\nv 0 1 .5\n"
                                 "f 1 3 2\nf 4 5 6\nf 1 2 5\nf 1 5 4\nf 2 3 6\nf 2 6 5\nf 3 1 4\nf 3 4 6\n"));
  std::string msh;
  for (const uint32_t count : {4u, 0u, 0u, 4u}) msh += test::raw(count);
  for (const float f : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 2.f, 0.f, 0.f, 0.f, 3.f}) msh += test::raw(f);
  for (const uint32_t i : {0u, 2u, 1u, 0u, 1u, 3u, 0u, 3u, 2u, 1u, 2u, 3u}) msh += test::raw(i);
  folder_.write("t.msh", std::string_view(msh));
  const std::string model =
      R"(<asset><mesh file="wedge.obj"/><mesh name="scaled" file="wedge.obj" scale="2 .5 -1"/>
      <mesh name="moved" file="wedge.obj" refpos="1 2 3" refquat="1 1 0 0"/><mesh file="t.msh"/>
      <mesh name="own" vertex="0 0 0 1 0 0 0 1 0 0 0 1" face="0 2 1 0 1 3 0 3 2 1 2 3"/>
      <mesh name="hull" vertex="-1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1  -1 -1 1  1 -1 1  1 1 1  -1 1 1  0 0 0"/></asset>
    <worldbody><geom type="mesh" mesh="wedge" pos="1 0 0" euler="10 20 30"/>
    <body pos="0 0 2"><geom type="mesh" mesh="scaled"/><geom type="mesh" mesh="moved" rgba="1 0 0 1"/></body>
    <geom type="mesh" mesh="t"/><geom type="mesh" mesh="own" pos="3 0 0"/><geom type="mesh" mesh="hull" pos="5 0 0"/>
    <body pos="0 5 0" euler="0 0 30"><geom type="box" mesh="wedge"/><geom type="cylinder" mesh="wedge" pos="1 1 1"/>
      <geom type="capsule" mesh="wedge"/><geom type="sphere" mesh="wedge"/><geom type="ellipsoid" mesh="scaled"/></body></worldbody>)";
  // MuJoCo 2 computes the extent of meshes from other bounds, and misplaces primitives with fitaabb.
  const std::string extent = "<statistic extent='4' center='1 1 1'/>";
  compare_text("inertia", extent + model);
}

TEST_F(MjcfOracleTest, MaterialsMatchMuJoCo) {
  folder_.write("map.png", test::png(4, 4, 0x00ff00ff));
  std::string field = test::raw<uint32_t>(2) + test::raw<uint32_t>(3);
  for (const float f : {1.f, 2.f, 3.f, 4.f, 5.f, 7.f}) field += test::raw(f);
  folder_.write("f.bin", std::string_view(field));
  compare_text(
      "fields",
      R"(<statistic extent="4" center="1 1 1"/><asset><hfield name="f" file="f.bin" size="1 2 .5 .1"/><hfield name="flat" nrow="3" ncol="4" size="1 1 1 1"/>
      <texture name="t" type="2d" file="map.png"/><texture name="c" builtin="checker" rgb1="1 0 0" rgb2="0 0 1" width="8" height="8"/>
      <texture name="g" type="2d" builtin="gradient" width="8" height="8" mark="cross"/>
      <material name="m" texture="t" texrepeat="3 2" texuniform="true" emission=".3" specular=".2" shininess=".9" reflectance=".4"/>
      <material name="n" texture="c" rgba=".1 .2 .3 .4"/><material name="o" texture="g"/></asset>
    <worldbody><geom type="hfield" hfield="f" pos="1 2 3" material="m"/><geom type="hfield" hfield="flat" material="n"/>
      <geom type="plane" size="2 3 .1" material="o"/><geom size="1" material="m" rgba="1 0 0 1"/></worldbody>)");
}

TEST_F(MjcfOracleTest, Tendons) {
  compare_text("tendons", R"(<default><tendon width=".02" rgba="0 1 0 1"/></default>
    <worldbody><site name="s0" pos="-2 .3 0"/><site name="s1" pos="2 .2 .5"/><site name="s2" pos="2 0 2"/><site name="s3" pos="-2 .1 2"/>
      <site name="side" pos="0 -3 0"/><site name="inner" pos="0 .1 .05"/><geom name="ball" size=".6"/>
      <body name="arm" pos="0 0 2" euler="80 0 0"><joint axis="1 0 0"/><geom name="tube" type="cylinder" size=".5 1"/>
        <site name="s4" pos="0 2 .4"/></body></worldbody>
    <tendon><spatial name="straight"><site site="s0"/><site site="s1"/><site site="s2"/></spatial>
      <spatial name="ball"><site site="s0"/><geom geom="ball"/><site site="s1"/></spatial>
      <spatial name="other side"><site site="s0"/><geom geom="ball" sidesite="side"/><site site="s1"/></spatial>
      <spatial name="inside" width=".1"><site site="s1"/><geom geom="ball" sidesite="inner"/><site site="s2"/></spatial>
      <spatial name="tube"><site site="s2"/><geom geom="tube"/><site site="s3"/><pulley divisor="2"/><site site="s3"/><site site="s0"/></spatial>
      <spatial name="hidden" group="4"><site site="s0"/><site site="s4"/></spatial>
      <spatial name="far"><site site="s3"/><geom geom="tube" sidesite="side"/><site site="s4"/></spatial></tendon>
    <keyframe><key qpos=".4"/></keyframe>)");
}

TEST_F(MjcfOracleTest, CompilerSettings) {
  compare_text(
      "discarded",
      R"(<compiler discardvisual="true"/><asset><material name="m" rgba="1 0 0 1"/></asset><worldbody>
    <geom size="1" material="m"/><geom size="2" contype="0" conaffinity="0"/></worldbody>)");
  compare_text(
      "mass",
      R"(<compiler inertiafromgeom="true" inertiagrouprange="1 2"/><worldbody><body name="a" pos="0 0 1"><freejoint/>
      <inertial pos="1 1 1" mass="5" diaginertia="1 1 1"/><geom size=".2" pos="1 0 0" group="1"/><geom size=".4" pos="0 2 0"/>
      <camera mode="trackcom" pos="1 2 3"/></body></worldbody><keyframe><key qpos="1 2 3 1 1 0 0"/></keyframe>)");
}

TEST_F(MjcfOracleTest, CollectionRobotsAgree) {
  FIRE3DV_NEEDS_ASSETS();
  for (const char* model :
       {"franka_emika_panda/scene.xml", "franka_emika_panda/hand.xml", "robotiq_2f85/2f85.xml"}) {
    const fs::path file = test::asset_collection_folder() / "robots" / model;
    ASSERT_TRUE(fs::exists(file)) << file;
    compare(file, model);
  }
}

TEST_F(MjcfOracleTest, RobotsOfTreeAgree) {
  for (const char* model : {"arm.xml", "crane.xml"})
    compare(fs::path(FIRE3DV_SOURCE_DIR) / "tests/assets/robots" / model, model);
}

}  // namespace
}  // namespace fire3dv::convert
